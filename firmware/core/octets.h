/* Fields to octets and back, little-endian, by shift and mask. A reader or writer that runs out
 * of octets turns not ok and stays so; what it reads from then on is zero. */
#ifndef HB_OCTETS_H
#define HB_OCTETS_H

#include "types.h"

typedef struct {
    const hb_octet *next;
    hb_u16 left;
    bool ok;
} hb_reader;

typedef struct {
    hb_octet *next;
    hb_u16 room;
    bool ok;
} hb_writer;

hb_octet hb_get_octet(hb_reader *reader);
hb_u16 hb_get_u16(hb_reader *reader);
hb_u32 hb_get_u32(hb_reader *reader);
float hb_get_f32(hb_reader *reader);

void hb_put_octet(hb_writer *writer, hb_octet octet);
void hb_put_u16(hb_writer *writer, hb_u16 value);
void hb_put_u32(hb_writer *writer, hb_u32 value);
void hb_put_f32(hb_writer *writer, float value);
void hb_put_text16(hb_writer *writer, const char *text);

/* A float's bits as they are sent (IEEE 754 single). */
hb_u32 hb_bits_of(float value);

#endif
