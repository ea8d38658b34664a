/* Types of the core. The compiler checks their widths.
 *
 * An octet is a value 0..255 in an unsigned char. On the C28x, which has no uint8_t, an unsigned
 * char has 16 bits and does not wrap at 256. Therefore octets are masked at their sources,
 * hb_receive and hb_put_octet. HB_OCTET makes them wider on a host, to test the masks.
 */
#ifndef HB_TYPES_H
#define HB_TYPES_H

#include <limits.h>
#include <stdbool.h>
#include <stdint.h>

#ifndef HB_OCTET
#define HB_OCTET unsigned char
#endif

typedef uint16_t hb_u16;
typedef int16_t hb_i16;
typedef uint32_t hb_u32;
typedef HB_OCTET hb_octet;

#define HB_ASSERT(name, condition) typedef char hb_assert_##name[(condition) ? 1 : -1]

HB_ASSERT(u16_has_16_bits, sizeof(hb_u16) * CHAR_BIT == 16);
HB_ASSERT(i16_has_16_bits, sizeof(hb_i16) * CHAR_BIT == 16);
HB_ASSERT(u32_has_32_bits, sizeof(hb_u32) * CHAR_BIT == 32);
HB_ASSERT(float_has_32_bits, sizeof(float) * CHAR_BIT == 32);
HB_ASSERT(octet_holds_8_bits, sizeof(hb_octet) * CHAR_BIT >= 8);

#endif
