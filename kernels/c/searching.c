/* Sorting, searching and paths. */

void insertion_sort(int *a, int n)
{
    for (int i = 1; i < n; i++) {
        int key = a[i], j = i - 1;
        while (j >= 0 && a[j] > key) {
            a[j + 1] = a[j];
            j--;
        }
        a[j + 1] = key;
    }
}

void bubble_sort(int *a, int n)
{
    int swapped = 1;
    while (swapped) {
        swapped = 0;
        for (int i = 0; i + 1 < n; i++)
            if (a[i] > a[i + 1]) {
                int t = a[i];
                a[i] = a[i + 1];
                a[i + 1] = t;
                swapped = 1;
            }
    }
}

/* Place of `key` in a sorted array, or -1. */
int binary_search(const int *a, int n, int key)
{
    int low = 0, high = n - 1;
    while (low <= high) {
        int middle = low + (high - low) / 2;
        if (a[middle] == key)
            return middle;
        if (a[middle] < key)
            low = middle + 1;
        else
            high = middle - 1;
    }
    return -1;
}

/* Lomuto's partition around the last element; returns where that went. */
int partition(int *a, int n)
{
    int pivot = a[n - 1], i = 0;
    for (int j = 0; j < n - 1; j++)
        if (a[j] < pivot) {
            int t = a[i];
            a[i] = a[j];
            a[j] = t;
            i++;
        }
    a[n - 1] = a[i];
    a[i] = pivot;
    return i;
}

/* First place of a pattern in a text, or -1. */
int find(const int *text, int n, const int *pattern, int m)
{
    for (int i = 0; i + m <= n; i++) {
        int j = 0;
        while (j < m && text[i + j] == pattern[j])
            j++;
        if (j == m)
            return i;
    }
    return -1;
}

void floyd_warshall(int n, int path[n][n])
{
    for (int k = 0; k < n; k++)
        for (int i = 0; i < n; i++)
            for (int j = 0; j < n; j++)
                if (path[i][k] + path[k][j] < path[i][j])
                    path[i][j] = path[i][k] + path[k][j];
}

/* Counts words of letters by what ends them: 0 blank, 1 comma, 2 full stop, else other. */
void count_ends(const int *text, int n, int *counts)
{
    for (int i = 1; i < n; i++) {
        if (text[i - 1] < 'a')
            continue;
        switch (text[i]) {
        case ' ':
            counts[0]++;
            break;
        case ',':
            counts[1]++;
            break;
        case '.':
            counts[2]++;
            break;
        default:
            if (text[i] < 'a')
                counts[3]++;
        }
    }
}
