/* Bytes, halves, constant tables and integers of 64 bits. */

#include <stdbool.h>
#include <stdint.h>
#include <string.h>

/* The remainders of 4 bits, for crc32_table. */
static const uint32_t crc_of_nibble[16] = {
    0x00000000, 0x1DB71064, 0x3B6E20C8, 0x26D930AC, 0x76DC4190, 0x6B6B51F4, 0x4DB26158, 0x5005713C,
    0xEDB88320, 0xF00F9344, 0xD6D6A3E8, 0xCB61B38C, 0x9B64C2B0, 0x86D3D2D4, 0xA00AE278, 0xBDBDF21C,
};

/* CRC-32 of bytes, half a byte at a time. */
uint32_t crc32_table(const uint8_t *data, int n)
{
    uint32_t crc = 0xFFFFFFFFu;
    for (int i = 0; i < n; i++) {
        crc ^= data[i];
        crc = crc >> 4 ^ crc_of_nibble[crc & 15];
        crc = crc >> 4 ^ crc_of_nibble[crc & 15];
    }
    return ~crc;
}

/* Length of a string that ends with a byte 0. */
int string_length(const char *text)
{
    int n = 0;
    while (text[n])
        n++;
    return n;
}

/* Place of the first byte `wanted`, or -1. */
int find_byte(const uint8_t *data, int n, uint8_t wanted)
{
    for (int i = 0; i < n; i++)
        if (data[i] == wanted)
            return i;
    return -1;
}

/* Adds one PCM stream to another, with gains in 1/256, and saturates. */
void mix_pcm(int16_t *restrict out, const int16_t *restrict a, const int16_t *restrict b,
             int gain_a, int gain_b, int n)
{
    for (int i = 0; i < n; i++) {
        int mixed = (a[i] * gain_a + b[i] * gain_b) >> 8;
        if (mixed > 32767)
            mixed = 32767;
        if (mixed < -32768)
            mixed = -32768;
        out[i] = (int16_t)mixed;
    }
}

/* The hash of Fowler, Noll and Vo (FNV-1a) in 64 bits. */
uint64_t fnv1a(const uint8_t *data, int n, uint64_t hash)
{
    for (int i = 0; i < n; i++)
        hash = (hash ^ data[i]) * 0x100000001B3u;
    return hash;
}

/* Marsaglia's xorshift of 64 bits, n times. */
uint64_t xorshift64(uint64_t state, int n)
{
    for (int i = 0; i < n; i++) {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
    }
    return state;
}

/* Digits of a number in a base, the last first; how many there are. */
int digits(uint32_t number, uint32_t base, uint8_t *out)
{
    static const char letters[] = "0123456789abcdefghijklmnopqrstuvwxyz";
    int n = 0;
    do {
        out[n++] = (uint8_t)letters[number % base];
        number /= base;
    } while (number);
    return n;
}

/* Places of bytes in ascending order: counting sort. */
void counting_sort(const uint8_t *data, uint8_t *sorted, int n)
{
    int32_t starts[65];
    memset(starts, 0, sizeof starts);
    for (int i = 0; i < n; i++)
        starts[(data[i] & 63) + 1]++;
    for (int i = 0; i < 64; i++)
        starts[i + 1] += starts[i];
    for (int i = 0; i < n; i++)
        sorted[starts[data[i] & 63]++] = data[i];
}

/* Which bytes occur in the text; how many different ones. */
int distinct_bytes(const uint8_t *text, int n, bool *occurs)
{
    uint8_t seen[256];
    memset(seen, 0, sizeof seen);
    for (int i = 0; i < n; i++)
        seen[text[i]] = 1;
    int count = 0;
    for (int i = 0; i < 256; i++) {
        occurs[i] = seen[i] != 0;
        count += seen[i];
    }
    return count;
}
