/* Frames: [sequence][type][payload][CRC-16 little-endian], COBS-stuffed so that they contain no
 * zero octet, and terminated by a zero octet. A damaged frame is dropped without a reply, and
 * the host repeats its request. */
#ifndef HB_WIRE_H
#define HB_WIRE_H

#include "dictionary.h"
#include "types.h"

#define HB_FRAME_OVERHEAD 4u                     /* sequence, type, CRC */
#define HB_MAX_PAYLOAD (HB_MAX_FRAME - HB_FRAME_OVERHEAD)
#define HB_MAX_STUFFED (HB_MAX_FRAME + 1u)       /* COBS adds one octet */
#define HB_MAX_ON_WIRE (HB_MAX_STUFFED + 1u)     /* and the terminator */

HB_ASSERT(cobs_adds_one_octet, HB_MAX_FRAME <= 254u);

/*@ requires count <= HB_MAX_FRAME;
    requires \valid_read(in + (0 .. count - 1)) && \valid(out + (0 .. count));
    requires \separated(out + (0 .. count), in + (0 .. count - 1));
    assigns out[0 .. count];
    ensures \result == count + 1;
*/
/* COBS. out must have room for count + count / 254 + 1 octets; returns the number written. */
hb_u16 hb_cobs_encode(const hb_octet *in, hb_u16 count, hb_octet *out);
/*@ requires count <= HB_MAX_STUFFED && in == out && \valid(out + (0 .. count - 1));
    assigns out[0 .. count - 1];
    ensures \result <= count;
*/
/* in == out is allowed. Returns the number of octets, 0 if the input is no COBS block. */
hb_u16 hb_cobs_decode(const hb_octet *in, hb_u16 count, hb_octet *out);

typedef struct {
    hb_octet octets[HB_MAX_STUFFED]; /* stuffed while being received, then plain */
    hb_u16 count;
    bool too_long; /* ignore octets until the next terminator */
} hb_receiver;

typedef struct {
    hb_octet sequence;
    hb_octet type;
    const hb_octet *payload; /* valid until the next octet is received */
    hb_u16 count;
} hb_frame;

/*@ predicate receives(hb_receiver *r) = \valid(r) && r->count <= HB_MAX_STUFFED; */

/*@ requires receives(receiver) && \valid(frame) && \separated(receiver, frame);
    assigns *receiver, *frame;
    ensures receives(receiver);
    ensures \result ==> frame->payload == &receiver->octets[2]
                        && frame->count + HB_FRAME_OVERHEAD <= HB_MAX_FRAME;
*/
/* Receives one octet; true if it completes a valid frame, which is then in *frame. */
bool hb_receive(hb_receiver *receiver, hb_octet octet, hb_frame *frame);

/*@ requires receives(receiver);
    assigns receiver->count, receiver->too_long;
    ensures receives(receiver);
*/
/* True if the octet ends a line that consists of '?' alone, typed since the last terminator. The
 * end of any typed line clears the receiver. No frame of a host is mistaken for a line, which
 * starts with '?' (63) or the CR (13) or LF (10) that ended the line before: a frame's first
 * octet, the distance to its first zero (COBS), is at most 9. A request without payload has 4
 * octets, "start" has 8, and all others contain a zero in the high octet of an index or count. */
bool hb_receive_question(hb_receiver *receiver, hb_octet octet);

/*@ requires count <= HB_MAX_PAYLOAD && \valid(plain + (0 .. HB_MAX_FRAME - 1));
    requires \valid(out + (0 .. HB_MAX_ON_WIRE - 1));
    requires \separated(out + (0 .. HB_MAX_ON_WIRE - 1), plain + (0 .. HB_MAX_FRAME - 1));
    assigns plain[0 .. HB_MAX_FRAME - 1], out[0 .. HB_MAX_ON_WIRE - 1];
    ensures 1 <= \result <= HB_MAX_ON_WIRE;
*/
/* Completes the frame in plain, whose payload of count octets starts at the third octet, and writes
 * it stuffed and terminated to out (HB_MAX_ON_WIRE octets). Returns the number of octets in out. */
hb_u16 hb_encode_frame(hb_octet sequence, hb_octet type, hb_octet plain[HB_MAX_FRAME],
                       hb_u16 count, hb_octet *out);

#endif
