/* CRC-16, polynomial 0x1021, not reflected, started from the dictionary's HB_CRC_START. */
#ifndef HB_CRC_H
#define HB_CRC_H

#include "types.h"

/*@ assigns \nothing; */
hb_u16 hb_crc_octet(hb_u16 crc, hb_octet octet);
/*@ requires \valid_read(octets + (0 .. count - 1));
    assigns \nothing;
*/
hb_u16 hb_crc_octets(hb_u16 crc, const hb_octet *octets, hb_u16 count);

/* Of the octets of a value as it is sent, little-endian. */
hb_u16 hb_crc_u16(hb_u16 crc, hb_u16 value);
hb_u16 hb_crc_f32(hb_u16 crc, float value);

#endif
