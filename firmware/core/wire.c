#include "wire.h"

#include "crc.h"

hb_u16 hb_cobs_encode(const hb_octet *in, hb_u16 count, hb_octet *out)
{
    hb_u16 code_at = 0; /* index of the present block's length */
    hb_u16 length = 1;
    hb_octet code = 1;

    for (hb_u16 i = 0; i < count; i++) {
        const hb_octet octet = in[i];
        if (octet != 0u) {
            out[length++] = octet;
            code++;
        }
        /* No empty block follows a full block at the end of the data. */
        if (octet == 0u || (code == 0xFFu && i + 1u < count)) {
            out[code_at] = code;
            code_at = length++;
            code = 1;
        }
    }
    out[code_at] = code;
    return length;
}

hb_u16 hb_cobs_decode(const hb_octet *in, hb_u16 count, hb_octet *out)
{
    hb_u16 from = 0;
    hb_u16 length = 0;

    while (from < count) {
        const hb_u16 code = in[from++];
        if (code == 0u || from + code - 1u > count) {
            return 0;
        }
        for (hb_u16 i = 1; i < code; i++) {
            out[length++] = in[from++];
        }
        if (code < 0xFFu && from < count) {
            out[length++] = 0;
        }
    }
    return length;
}

/* Unpacks the received octets; true for a valid frame. */
static bool open_frame(hb_receiver *receiver, hb_frame *frame)
{
    hb_octet *plain = receiver->octets;
    const hb_u16 count = hb_cobs_decode(plain, receiver->count, plain);

    if (count < HB_FRAME_OVERHEAD || count > HB_MAX_FRAME) {
        return false;
    }
    const hb_u16 crc = (hb_u16)(plain[count - 2u] | (hb_u16)((hb_u16)plain[count - 1u] << 8));
    if (crc != hb_crc_octets(HB_CRC_START, plain, (hb_u16)(count - 2u))) {
        return false;
    }
    frame->sequence = plain[0];
    frame->type = plain[1];
    frame->payload = &plain[2];
    frame->count = (hb_u16)(count - HB_FRAME_OVERHEAD);
    return true;
}

bool hb_receive(hb_receiver *receiver, hb_octet octet, hb_frame *frame)
{
    octet = (hb_octet)(octet & 0xFFu);
    if (octet == 0u) {
        const bool valid = !receiver->too_long && open_frame(receiver, frame);
        receiver->count = 0;
        receiver->too_long = false;
        return valid;
    }
    if (receiver->count == HB_MAX_STUFFED) {
        receiver->too_long = true;
    } else {
        receiver->octets[receiver->count++] = octet;
    }
    return false;
}

static bool ends_line(hb_octet octet)
{
    return octet == 13u || octet == 10u; /* CR, LF */
}

bool hb_receive_question(hb_receiver *receiver, hb_octet octet)
{
    hb_u16 at = 0;

    if (!ends_line((hb_octet)(octet & 0xFFu))) {
        return false;
    }
    while (at < receiver->count && ends_line(receiver->octets[at])) {
        at++;
    }
    if (at == receiver->count || receiver->octets[at] < ' ') {
        return false; /* an empty line, or a frame */
    }
    const bool asked = at + 1u == receiver->count && receiver->octets[at] == '?';
    receiver->count = 0;
    receiver->too_long = false;
    return asked;
}

hb_u16 hb_encode_frame(hb_octet sequence, hb_octet type, hb_octet plain[HB_MAX_FRAME],
                       hb_u16 count, hb_octet *out)
{
    hb_u16 length = (hb_u16)(count + 2u);

    plain[0] = sequence;
    plain[1] = type;
    const hb_u16 crc = hb_crc_octets(HB_CRC_START, plain, length);
    plain[length++] = (hb_octet)(crc & 0xFFu);
    plain[length++] = (hb_octet)(crc >> 8);

    const hb_u16 stuffed = hb_cobs_encode(plain, length, out);
    out[stuffed] = 0;
    return (hb_u16)(stuffed + 1u);
}
