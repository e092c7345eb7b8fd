// Which slot starts: the one the last boot record names, if it is sound and has starts left, else the other.
// No chip in here: tests run this very file on a simulated flash and cut the power in every write.
#include "loader.h"

#define BLANK 0xFFFFFFFFu

static uint32_t crc_table[4][256];

// CRC-32 as zlib has it, four bytes a turn: 448 KiB take a quarter of the time that a byte a turn would.
static void make_crc_table(void) {
    for (uint32_t byte = 0; byte < 256; byte++) {
        uint32_t crc = byte;
        for (int bit = 0; bit < 8; bit++) {
            crc = crc >> 1 ^ (crc & 1 ? 0xEDB88320u : 0);
        }
        crc_table[0][byte] = crc;
    }
    for (uint32_t byte = 0; byte < 256; byte++) {
        for (int turn = 1; turn < 4; turn++) {
            uint32_t before = crc_table[turn - 1][byte];
            crc_table[turn][byte] = before >> 8 ^ crc_table[0][before & 0xFF];
        }
    }
}

static uint32_t crc32(const uint32_t *word, uint32_t bytes) {
    uint32_t crc = BLANK;
    for (; bytes; bytes -= 4) {
        crc ^= *word++;
        crc = crc_table[3][crc & 0xFF] ^ crc_table[2][crc >> 8 & 0xFF] ^ crc_table[1][crc >> 16 & 0xFF] ^
              crc_table[0][crc >> 24];
    }
    return ~crc;
}

uint32_t slot_at(int slot) {
    return slot ? 0x80000u : 0x10000u;
}

static const uint32_t *words(const uint8_t *flash, uint32_t at) {
    return (const uint32_t *)(flash + at);
}

static int is_sound(const uint8_t *flash, int slot) {
    const uint32_t *raw = words(flash, slot_at(slot));
    const struct header *header = (const struct header *)raw;
    if (header->magic != HEADER_MAGIC || header->format != HEADER_FORMAT || header->slot != (uint32_t)slot) {
        return 0;
    }
    if (header->length == 0 || header->length > IMAGE_MOST || header->length % 4) {
        return 0;
    }
    return crc32(raw, HEADER_BYTES - 4) == raw[HEADER_BYTES / 4 - 1] &&
           crc32(raw + HEADER_BYTES / 4, header->length) == header->image_crc;
}

static int is_record(const uint32_t *pair) {
    return pair[1] == ~pair[0] && (pair[0] & ~0x1FFu) == RECORD_MAGIC;
}

// Find the last record, 0 if there is none, and where the next one goes: behind the last word that is not blank.
static uint32_t read_records(const uint8_t *flash, uint32_t *next) {
    const uint32_t *pair = words(flash, RECORDS_AT);
    uint32_t last = 0;
    *next = 0;
    for (uint32_t at = 0; at < RECORDS_BYTES; at += 8, pair += 2) {
        if (is_record(pair)) {
            last = pair[0];
        }
        if (pair[0] != BLANK || pair[1] != BLANK) {
            *next = at + 8;
        }
    }
    return last;
}

// Append a record and read it back; what does not hold is passed over. Return 0 if there is no room left.
static int append(const uint8_t *flash, program_word program, uint32_t next, uint32_t record) {
    for (; next < RECORDS_BYTES; next += 8) {
        const volatile uint32_t *pair = words(flash, RECORDS_AT + next);
        program(RECORDS_AT + next, record);
        program(RECORDS_AT + next + 4, ~record);
        if (pair[0] == record && pair[1] == ~record) {
            return 1;
        }
    }
    return 0;
}

int choose_slot(const uint8_t *flash, program_word program) {
    uint32_t next;
    uint32_t record = read_records(flash, &next);
    int slot = record >> 8 & 1;
    uint32_t starts = record ? record & 0xFF : CONFIRMED;
    make_crc_table();
    if (starts != CONFIRMED && is_sound(flash, slot)) {
        if (starts && append(flash, program, next, RECORD(slot, starts - 1))) {
            return slot;
        }
        slot = !slot; // its starts are used up, or can't be counted: the other first
    }
    if (is_sound(flash, slot)) {
        return slot;
    }
    return is_sound(flash, !slot) ? !slot : NO_SLOT;
}
