#include "host.h"

#include <stdlib.h>

#define QUEUE_OCTETS 4096u /* a power of two, so that the counters may wrap */

typedef struct {
    unsigned char octet[QUEUE_OCTETS];
    uint32_t written;
    uint32_t read;
} queue;

struct hb_host {
    hb_core core;
    hb_log_ring ring;
    queue to_board;
    queue to_host;
};

static uint32_t waiting(const queue *q)
{
    return q->written - q->read;
}

static bool push(queue *q, unsigned char octet)
{
    if (waiting(q) == QUEUE_OCTETS) {
        return false;
    }
    q->octet[q->written++ % QUEUE_OCTETS] = octet;
    return true;
}

static unsigned char pop(queue *q)
{
    return q->octet[q->read++ % QUEUE_OCTETS];
}

static bool uart_read(void *context, hb_octet *octet)
{
    queue *q = &((hb_host *)context)->to_board;

    if (waiting(q) == 0u) {
        return false;
    }
    /* Where an octet is wider than 8 bits, a UART may leave anything in the upper ones. */
    *octet = (hb_octet) ~(0xFFu & ~(unsigned)pop(q));
    return true;
}

static hb_u16 uart_write(void *context, const hb_octet *octets, hb_u16 count)
{
    queue *q = &((hb_host *)context)->to_host;
    hb_u16 accepted = 0;

    while (accepted < count && push(q, (unsigned char)octets[accepted])) {
        accepted++;
    }
    return accepted;
}

/* Ticks come from the caller's own loop, never in the middle of a poll. */
static void no_interrupts(void *context)
{
    (void)context;
}

hb_host *hb_host_create(uint16_t boots)
{
    hb_host *host = calloc(1, sizeof *host);

    if (host != NULL) {
        const hb_hal hal = {host, "host", uart_read, uart_write, no_interrupts, no_interrupts};
        hb_core_init(&host->core, &hal, host->ring, boots);
    }
    return host;
}

void hb_host_destroy(hb_host *host)
{
    free(host);
}

void hb_host_tick(hb_host *host, const uint16_t *adc, int16_t *dac)
{
    hb_core_tick(&host->core, adc, dac);
}

uint32_t hb_host_poll(hb_host *host)
{
    hb_core_poll(&host->core);
    return waiting(&host->to_host);
}

uint32_t hb_host_receive(hb_host *host, const unsigned char *octets, uint32_t count)
{
    uint32_t taken = 0;

    while (taken < count && push(&host->to_board, octets[taken])) {
        taken++;
    }
    return taken;
}

uint32_t hb_host_transmit(hb_host *host, unsigned char *octets, uint32_t capacity)
{
    uint32_t given = 0;

    while (given < capacity && waiting(&host->to_host) > 0u) {
        octets[given++] = pop(&host->to_host);
    }
    return given;
}
