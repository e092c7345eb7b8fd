// The board's flash as the loader sees it: where things lie, what a slot's header and a boot record hold.
// firmware/flash_map.py says the same in Python; tests/host/boards/flash/test_loader.py compares them.
#ifndef CARAMELO_LOADER_H
#define CARAMELO_LOADER_H

#include <stdint.h>

#define RECORDS_AT 0x4000u // boot records: sector 1, only ever appended to by the loader
#define RECORDS_BYTES 0x4000u

#define HEADER_BYTES 512u
#define HEADER_MAGIC 0x4C524143u // "CARL"
#define HEADER_FORMAT 1u
#define IMAGE_MOST (448u * 1024u - HEADER_BYTES) // what fits either slot

// A slot's header. More follows that the loader does not look at; its last word is the CRC-32 of all before.
struct header {
    uint32_t magic, format, slot, length, image_crc;
};

// A boot record is a word and its complement. A cut of the power only leaves bits unwritten, or bits erased, on both
// sides alike: nothing that such a cut can leave is a word and its complement, unless it is the whole record.
#define RECORD_MAGIC 0xB0070000u
#define RECORD(slot, starts) (RECORD_MAGIC | (uint32_t)(slot) << 8 | (starts))
#define CONFIRMED 0xFFu // in the place of the starts that are left: started as often as wanted

#define SLOTS 2
#define NO_SLOT (-1)

typedef void (*program_word)(uint32_t at, uint32_t word);

// Return the slot to start, 0 or 1, or NO_SLOT. Counts the start of a slot on trial before returning.
int choose_slot(const uint8_t *flash, program_word program);

// Return where a slot's header lies, from the beginning of the flash.
uint32_t slot_at(int slot);

#endif
