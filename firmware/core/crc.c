#include "crc.h"

#include "octets.h"

/* Eight steps of the polynomial division at once, without a table. */
hb_u16 hb_crc_octet(hb_u16 crc, hb_octet octet)
{
    crc = (hb_u16)((hb_u16)(crc >> 8) | (hb_u16)(crc << 8));
    crc = (hb_u16)(crc ^ (octet & 0xFFu));
    crc = (hb_u16)(crc ^ ((crc & 0xFFu) >> 4));
    crc = (hb_u16)(crc ^ (hb_u16)(crc << 12));
    crc = (hb_u16)(crc ^ (hb_u16)((crc & 0xFFu) << 5));
    return crc;
}

hb_u16 hb_crc_octets(hb_u16 crc, const hb_octet *octets, hb_u16 count)
{
    for (hb_u16 i = 0; i < count; i++) {
        crc = hb_crc_octet(crc, octets[i]);
    }
    return crc;
}

hb_u16 hb_crc_u16(hb_u16 crc, hb_u16 value)
{
    crc = hb_crc_octet(crc, (hb_octet)value); /* masked by hb_crc_octet */
    return hb_crc_octet(crc, (hb_octet)(value >> 8));
}

hb_u16 hb_crc_f32(hb_u16 crc, float value)
{
    const hb_u32 bits = hb_bits_of(value);

    crc = hb_crc_u16(crc, (hb_u16)(bits & 0xFFFFu));
    return hb_crc_u16(crc, (hb_u16)(bits >> 16));
}
