"""Loops and branches of every form."""

import numpy as np

import vividc

FOUR = np.float32(4.0)
TWO = np.float32(2.0)
ZERO = np.float32(0.0)
TAB, NEWLINE, SPACE, HASH, OPEN, CLOSE = 9, 10, 32, 35, 40, 41
BLANK, WORD, COMMENT = 0, 1, 2
HALT, SET, LOAD, STORE, ADD, DECREMENT, JUMP = 0, 1, 2, 3, 4, 5, 6
FIRST_PRIME = 2


@vividc.kernel("void(int32[::1], int32[::1], int32[::1])")
def gcd(a, b, out):
    """Greatest common divisors of positive numbers by subtraction."""
    for i in range(len(a)):
        x = a[i]
        y = b[i]
        while x != y:
            if x > y:
                x = np.int32(x - y)
            else:
                y = np.int32(y - x)
        out[i] = x


@vividc.kernel("void(int32[::1], int32[::1])")
def collatz(start, steps):
    for i in range(len(start)):
        n = start[i]
        count = 0
        while n != 1:
            n = np.int32(3 * n + 1) if n & 1 else n >> 1
            count += 1
        steps[i] = count


@vividc.kernel("void(float32[::1], float32[::1], int32, int32[:, ::1])")
def mandelbrot(real, imaginary, limit, out):
    for row in range(len(imaginary)):
        for column in range(len(real)):
            x = ZERO
            y = ZERO
            n = 0
            while n < limit and x * x + y * y <= FOUR:
                x, y = x * x - y * y + real[column], TWO * x * y + imaginary[row]
                n += 1
            out[row, column] = n


@vividc.kernel("int32(int32[:, ::1], int32)")
def nested_breaks(a, limit):
    """Sums rows up to their first zero; stops at the first sum above the limit."""
    total = 0
    for i in range(a.shape[0]):
        row = 0
        for j in range(a.shape[1]):
            if a[i, j] == 0:
                break
            if a[i, j] < 0:
                continue
            row += a[i, j] & 255
        if row == 0:
            continue
        total += row
        if total > limit:
            break
    return total


@vividc.kernel("int32(int32[::1])")
def follow(link):
    """Follows links from 0 until one is negative or visited."""
    steps = 0
    at = 0
    while True:
        after = link[at]
        if after < 0:
            break
        link[at] = -1
        steps += 1
        at = after
    return steps


@vividc.kernel("int32(int32[:, :, ::1], int32)")
def first_match(volume, wanted):
    """The first cell that holds the value, as one number; three loops are left at once."""
    for z in range(volume.shape[0]):
        for y in range(volume.shape[1]):
            for x in range(volume.shape[2]):
                if volume[z, y, x] == wanted:
                    return (z << 16) | (y << 8) | x
    return -1


@vividc.kernel("int32(int32[::1], int32[::1])")
def count_words(text, lengths):
    """A state machine over characters: lengths of words; # starts a comment."""
    state = BLANK
    words = 0
    length = 0
    for c in text:
        if state == COMMENT:
            if c == NEWLINE:
                state = BLANK
        elif c == HASH:
            if state == WORD:
                lengths[words] = length
                words += 1
            state = COMMENT
        elif c in (SPACE, NEWLINE, TAB):
            if state == WORD:
                lengths[words] = length
                words += 1
            state = BLANK
        else:
            if state == BLANK:
                length = 0
            state = WORD
            length += 1
    if state == WORD:
        lengths[words] = length
        words += 1
    return words


@vividc.kernel("int32(int32[::1])")
def sieve(prime):
    """Marks primes with 1 and returns how many there are."""
    n = len(prime)
    for i in range(n):
        prime[i] = i >= FIRST_PRIME
    i = np.int32(FIRST_PRIME)
    while np.int32(i * i) < n:
        if prime[i]:
            j = np.int32(i * i)
            while j < n:
                prime[j] = 0
                j = np.int32(j + i)
        i = np.int32(i + 1)
    count = 0
    for i in range(n):
        count += prime[i]
    return count


@vividc.kernel("void(int32[::1], int32[::1], int32)")
def run_lengths(x, out, minimum):
    """Each element's run of equal values, if it is long enough, else 0."""
    n = len(x)
    for i in range(n):
        left = i
        while left > 0 and x[left - 1] == x[i]:
            left -= 1
        right = i
        while right + 1 < n and x[right + 1] == x[i]:
            right += 1
        run = right - left + 1
        out[i] = run if run >= minimum else 0


@vividc.kernel("int32(int32[::1], int32[::1])")
def bracket_match(text, stack):
    """Position of the first bracket without a partner, or -1."""
    depth = 0
    for i in range(len(text)):
        if text[i] == OPEN:
            stack[depth] = i
            depth += 1
        elif text[i] == CLOSE:
            if depth == 0:
                return i
            depth -= 1
    return stack[0] if depth > 0 else -1


@vividc.kernel("int32(int32[::1], int32[::1], int32)")
def virtual_machine(code, memory, limit):
    """Runs pairs (operation, operand) on an accumulator, at most `limit` of them."""
    counter = 0
    acc = np.int32(0)
    for _ in range(limit):
        operation = code[counter]
        operand = code[counter + 1]
        counter += 2
        if operation == HALT:
            break
        elif operation == SET:
            acc = operand
        elif operation == LOAD:
            acc = memory[operand]
        elif operation == STORE:
            memory[operand] = acc
        elif operation == ADD:
            acc = np.int32(acc + memory[operand])
        elif operation == DECREMENT:
            acc = np.int32(acc - 1)
        elif operation == JUMP and acc != 0:
            counter = operand
    return acc


@vividc.kernel("int32(int32[::1])")
def queens(column):
    """Ways to place as many queens as `column` is long, by backtracking without recursion."""
    n = len(column)
    count = 0
    row = 0
    column[0] = -1
    while row >= 0:
        column[row] += 1
        if column[row] == n:
            row -= 1
            continue
        attacked = False
        for above in range(row):
            difference = column[above] - column[row]
            if difference in (0, row - above, above - row):
                attacked = True
                break
        if attacked:
            continue
        if row == n - 1:
            count += 1
        else:
            row += 1
            column[row] = -1
    return count
