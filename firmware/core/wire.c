#include "wire.h"

#include "crc.h"

hb_u16 hb_cobs_encode(const hb_octet *in, hb_u16 count, hb_octet *out)
{
    hb_u16 code_at = 0; /* index of the present block's length */
    hb_u16 length = 1;
    hb_octet code = 1;

    /*@ loop invariant i <= count && 1 <= code <= 255 && length == code_at + code;
        loop invariant length == i + 1;
        loop assigns i, length, code, code_at, out[0 .. count];
        loop variant count - i; */
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

    /*@ loop invariant length <= from <= count;
        loop assigns from, length, out[0 .. count - 1];
        loop variant count - from; */
    while (from < count) {
        const hb_u16 code = in[from++];
        if (code == 0u || from + code - 1u > count) {
            return 0;
        }
        /*@ loop invariant 1 <= i <= code && length < from && from + (code - i) <= count;
            loop invariant from >= \at(from, LoopEntry);
            loop assigns i, from, length, out[0 .. count - 1];
            loop variant code - i; */
        for (hb_u16 i = 1; i < code; i++) {
            out[length++] = in[from++];
        }
        if (code < 0xFFu && from < count) {
            out[length++] = 0;
        }
    }
    return length;
}

/*@ requires receives(receiver) && \valid(frame) && \separated(receiver, frame);
    assigns receiver->octets[0 .. HB_MAX_STUFFED - 1], *frame;
    ensures \result ==> frame->payload == &receiver->octets[2]
                        && frame->count + HB_FRAME_OVERHEAD <= HB_MAX_FRAME;
*/
/* Unpacks the received octets; true for a valid frame. */
static bool open_frame(hb_receiver *receiver, hb_frame *frame)
{
    hb_octet *plain = receiver->octets;
    const hb_u16 count = hb_cobs_decode(plain, receiver->count, plain);

    if (count < HB_FRAME_OVERHEAD || count > HB_MAX_FRAME) {
        return false;
    }
    const hb_u16 crc = (hb_u16)(plain[count - 2u] + 256u * plain[count - 1u]);
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

/*@ assigns \nothing; */
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
    /*@ loop invariant at <= receiver->count;
        loop assigns at;
        loop variant receiver->count - at; */
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
