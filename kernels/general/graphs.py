"""Graphs and dynamic programming."""

import numpy as np

import vividc

FAR = 1 << 20


@vividc.kernel("void(int32[:, ::1])")
def floyd_warshall(distance):
    n = distance.shape[0]
    for k in range(n):
        for i in range(n):
            for j in range(n):
                through = np.int32(distance[i, k] + distance[k, j])
                distance[i, j] = min(distance[i, j], through)


@vividc.kernel("int32(int32[::1], int32[::1], int32[::1], int32[::1])")
def bellman_ford(source, target, weight, distance):
    """Relaxes all edges until nothing changes; returns the rounds, or -1 for a negative cycle."""
    for step in range(len(distance)):
        changed = False
        for e in range(len(source)):
            reached = np.int32(distance[source[e]] + weight[e])
            if distance[source[e]] < FAR and reached < distance[target[e]]:
                distance[target[e]] = reached
                changed = True
        if not changed:
            return step
    return -1


@vividc.kernel("int32(int32[::1], int32[::1], int32, int32[::1], int32[::1])")
def bfs(row_start, neighbour, root, level, queue):
    """Levels from the root, `level` starts as -1; returns how many nodes were reached."""
    head = 0
    tail = 1
    queue[0] = root
    level[root] = 0
    while head < tail:
        node = queue[head]
        head += 1
        for e in range(row_start[node], row_start[node + 1]):
            other = neighbour[e]
            if level[other] < 0:
                level[other] = level[node] + 1
                queue[tail] = other
                tail += 1
    return tail


@vividc.kernel("int32(int32[::1], int32[::1], int32[::1])")
def components(a, b, parent):
    """Union-find over an edge list with path halving; returns the number of components."""
    for i in range(len(parent)):
        parent[i] = i
    count = len(parent)
    for e in range(len(a)):
        x = a[e]
        y = b[e]
        while parent[x] != x:
            parent[x] = parent[parent[x]]
            x = parent[x]
        while parent[y] != y:
            parent[y] = parent[parent[y]]
            y = parent[y]
        if x != y:
            parent[y] = x
            count -= 1
    return count


@vividc.kernel("int32(int32[::1], int32[::1], int32[:, ::1])")
def longest_common(a, b, table):
    """Length of the longest common subsequence."""
    for i in range(len(a) + 1):
        table[i, 0] = 0
    for j in range(len(b) + 1):
        table[0, j] = 0
    for i in range(1, len(a) + 1):
        for j in range(1, len(b) + 1):
            if a[i - 1] == b[j - 1]:
                table[i, j] = table[i - 1, j - 1] + 1
            else:
                table[i, j] = max(table[i - 1, j], table[i, j - 1])
    return table[len(a), len(b)]


@vividc.kernel("int32(int32[::1], int32[::1], int32[::1])")
def edit_distance(a, b, row):
    """Levenshtein distance with one row."""
    for j in range(len(b) + 1):
        row[j] = j
    for i in range(len(a)):
        diagonal = row[0]
        row[0] = i + 1
        for j in range(len(b)):
            cost = diagonal if a[i] == b[j] else np.int32(diagonal + 1)
            diagonal = row[j + 1]
            row[j + 1] = np.int32(min(cost, np.int32(diagonal + 1), np.int32(row[j] + 1)))
    return row[len(b)]


@vividc.kernel("int32(int32[::1], int32[::1], int32[::1])")
def knapsack(weight, value, best):
    """0/1 knapsack; `best` has one entry for each capacity and starts as zeros."""
    capacity = len(best) - 1
    for i in range(len(weight)):
        for c in range(capacity, -1, -1):
            if c < weight[i]:
                break
            best[c] = max(best[c], np.int32(best[c - weight[i]] + value[i]))
    return best[capacity]


@vividc.kernel("int32(int32[::1], int32[::1])")
def longest_increasing(x, length):
    longest = 0
    for i in range(len(x)):
        best = 0
        for j in range(i):
            if x[j] < x[i] and length[j] > best:
                best = length[j]
        length[i] = best + 1
        longest = max(longest, best + 1)
    return longest


@vividc.kernel("int32(int32[::1])")
def largest_subarray(x):
    """Largest sum of a run of at least one value (Kadane)."""
    best = x[0]
    ending = x[0]
    for i in range(1, len(x)):
        ending = max(np.int32(ending + x[i]), x[i])
        best = max(best, ending)
    return best


@vividc.kernel("int32(int32[::1], int32[:, ::1])")
def matrix_chain(size, cost):
    """Fewest multiplications for a chain of matrices; `cost` starts as zeros."""
    n = len(size) - 1
    for span in range(1, n):
        for i in range(n - span):
            j = i + span
            best = np.int32(2147483647)
            for k in range(i, j):
                product = size[i] * size[k + 1] * size[j + 1]
                total = np.int32(cost[i, k] + cost[k + 1, j] + product)
                best = min(best, total)
            cost[i, j] = best
    return cost[0, n - 1]
