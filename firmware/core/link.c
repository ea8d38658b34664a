#include "link.h"

#include "commands.h"
#include "config.h"
#include "octets.h"
#include "payloads.h"

void hb_link_init(hb_link *link, hb_core *core)
{
    link->core = core;
    link->receiver.count = 0;
    link->receiver.too_long = false;
    link->out_count = 0;
    link->out_sent = 0;
}

/* Passes the pending reply to the UART; true when all of it has gone. */
static bool flush(hb_link *link)
{
    const hb_hal *hal = &link->core->hal;

    if (link->out_sent < link->out_count) {
        const hb_u16 accepted = hal->uart_write(hal->context, &link->out[link->out_sent],
                                                (hb_u16)(link->out_count - link->out_sent));
        link->out_sent = (hb_u16)(link->out_sent + accepted);
    }
    return link->out_sent == link->out_count;
}

static void answer(hb_link *link, const hb_frame *frame)
{
    const hb_hal *hal = &link->core->hal;
    const hb_writer empty = {&link->reply[2], HB_MAX_PAYLOAD, true};
    hb_writer reply = empty;
    hb_octet type = (hb_octet)(frame->type | HB_REPLY);

    const bool masked = frame->type != HB_MESSAGE_READ_LOG; /* which masks record by record */

    if (masked) {
        hal->mask_control(hal->context);
    }
    const hb_u16 refusal = hb_command(link->core, frame, &reply);
    if (!masked) {
        hal->mask_control(hal->context);
    }
    /* A request that the board can't read does not show that its host is in control. */
    if (refusal != HB_REFUSAL_UNKNOWN_MESSAGE && refusal != HB_REFUSAL_BAD_PAYLOAD) {
        hb_core_heartbeat(link->core);
    }
    hal->unmask_control(hal->context);

    if (refusal != HB_REFUSAL_NONE) {
        hb_error_reply error;
        error.request = frame->type;
        error.refusal = refusal;
        reply = empty;
        type = HB_ERROR;
        hb_put_error(&reply, &error);
    }
    link->out_count = hb_encode_frame(frame->sequence, type, link->reply,
                                      (hb_u16)(HB_MAX_PAYLOAD - reply.room), link->out);
    link->out_sent = 0;
}

static void put_text(hb_writer *writer, const char *text)
{
    while (*text != '\0') {
        hb_put_octet(writer, (hb_octet)*text++);
    }
}

/* Sends a line of text for a terminal. Its final zero octet makes a host drop it as a damaged
 * frame. */
static void send_status_line(hb_link *link)
{
    static const char state[][HB_NAME_SIZE] = HB_STATE_NAMES;
    static const char fault[][HB_NAME_SIZE] = HB_FAULT_NAMES;
    const hb_core *core = link->core;
    hb_writer line = {link->out, HB_MAX_ON_WIRE, true};

    put_text(&line, HB_FIRMWARE " on ");
    put_text(&line, core->hal.board);
    put_text(&line, ", " HB_VERSION_TEXT ", state ");
    put_text(&line, state[core->state]);
    put_text(&line, ", fault ");
    put_text(&line, fault[core->fault]);
    put_text(&line, "\r\n");
    hb_put_octet(&line, 0u);
    link->out_count = (hb_u16)(HB_MAX_ON_WIRE - line.room);
    link->out_sent = 0;
}

void hb_link_poll(hb_link *link)
{
    const hb_hal *hal = &link->core->hal;
    hb_octet octet;
    hb_frame frame;

    while (flush(link) && hal->uart_read(hal->context, &octet)) {
        if (hb_receive_question(&link->receiver, octet)) {
            send_status_line(link); /* no heartbeat: the question does not come from a host */
        } else if (hb_receive(&link->receiver, octet, &frame)) {
            answer(link, &frame);
        }
    }
}
