#include "octets.h"

/* Both members are 32 bits wide (types.h), so one can be read as the other. */
typedef union {
    hb_u32 bits;
    float value;
} hb_single;

hb_u32 hb_bits_of(float value)
{
    hb_single single;
    single.value = value;
    return single.bits;
}

hb_octet hb_get_octet(hb_reader *reader)
{
    if (reader->left == 0u) {
        reader->ok = false;
        return 0;
    }
    reader->left--;
    return *reader->next++;
}

hb_u16 hb_get_u16(hb_reader *reader)
{
    const hb_u16 low = hb_get_octet(reader);
    const hb_u16 high = hb_get_octet(reader);
    return (hb_u16)(low | (hb_u16)(high << 8));
}

hb_u32 hb_get_u32(hb_reader *reader)
{
    const hb_u32 low = hb_get_u16(reader);
    const hb_u32 high = hb_get_u16(reader);
    return low | (high << 16);
}

float hb_get_f32(hb_reader *reader)
{
    hb_single single;
    single.bits = hb_get_u32(reader);
    return single.value;
}

bool hb_get_end(const hb_reader *reader)
{
    return reader->ok && reader->left == 0u;
}

void hb_put_octet(hb_writer *writer, hb_octet octet)
{
    if (writer->room == 0u) {
        writer->ok = false;
        return;
    }
    writer->room--;
    *writer->next++ = (hb_octet)(octet & 0xFFu);
}

void hb_put_u16(hb_writer *writer, hb_u16 value)
{
    hb_put_octet(writer, (hb_octet)value); /* masked by hb_put_octet */
    hb_put_octet(writer, (hb_octet)(value >> 8));
}

void hb_put_u32(hb_writer *writer, hb_u32 value)
{
    hb_put_u16(writer, (hb_u16)(value & 0xFFFFu));
    hb_put_u16(writer, (hb_u16)(value >> 16));
}

void hb_put_f32(hb_writer *writer, float value)
{
    hb_put_u32(writer, hb_bits_of(value));
}

void hb_put_text16(hb_writer *writer, const char *text)
{
    for (hb_u16 i = 0; i < 16u; i++) {
        hb_put_octet(writer, (hb_octet)*text);
        if (*text != '\0') {
            text++;
        }
    }
}
