#include "host.h"

#include <stdlib.h>

#include "../simulated.h"

#define RING_RECORDS 1024u
#define QUEUE_OCTETS 4096u /* a power of two, so that the counters may wrap */

/* On a line with a baud rate. */
#define TRANSMIT_FIFO 16u    /* as the F28335's SCI has */
#define RECEIVE_BUFFER 128u  /* hal.h asks for 64 */
#define OCTET_BITS 10u       /* with start and stop bit */
#define OCTET_CREDIT (OCTET_BITS * HB_RATE_HZ) /* baud credits a tick are exact */

typedef struct {
    unsigned char octet[QUEUE_OCTETS];
    uint32_t room; /* at most QUEUE_OCTETS */
    uint32_t written;
    uint32_t read;
} queue;

/* One direction of the line: octets that wait to go, and those that have come. */
typedef struct {
    queue going;
    queue come;
    uint32_t credit; /* towards the next octet */
} direction;

HB_ASSERT(ring_size_is_valid, HB_RING_SIZE_IS_VALID(RING_RECORDS));

struct hb_host {
    hb_core core; /* without the ring: together they exceed the largest object of an AVR compiler */
    hb_link link;
    uint32_t baud; /* 0: octets take no time */
    direction to_board;
    direction to_host;
    bool frame_ended; /* among what has come to the host */
};

static uint32_t waiting(const queue *q)
{
    return q->written - q->read;
}

static bool push(queue *q, unsigned char octet)
{
    if (waiting(q) == q->room) {
        return false;
    }
    q->octet[q->written++ % QUEUE_OCTETS] = octet;
    return true;
}

static unsigned char pop(queue *q)
{
    return q->octet[q->read++ % QUEUE_OCTETS];
}

static void open_direction(direction *line, uint32_t going, uint32_t come)
{
    line->going.room = going;
    line->come.room = come;
}

static void hand_to_host(hb_host *host, unsigned char octet)
{
    if (push(&host->to_host.come, octet) && octet == 0u) {
        host->frame_ended = true;
    }
}

/* One tick of a direction; an octet that finds no room at its end is lost, as on any UART.
 * Credit is kept only while octets wait: the next one starts when it comes. */
static void carry(hb_host *host, direction *line)
{
    line->credit = waiting(&line->going) > 0u ? line->credit + host->baud : 0u;
    while (line->credit >= OCTET_CREDIT && waiting(&line->going) > 0u) {
        const unsigned char octet = pop(&line->going);
        line->credit -= OCTET_CREDIT;
        if (line == &host->to_host) {
            hand_to_host(host, octet);
        } else {
            push(&line->come, octet);
        }
    }
}

static bool uart_read(void *context, hb_octet *octet)
{
    queue *q = &((hb_host *)context)->to_board.come;

    if (waiting(q) == 0u) {
        return false;
    }
    /* Where an octet is wider than 8 bits, a UART may leave anything in the upper ones. */
    *octet = (hb_octet) ~(0xFFu & ~(unsigned)pop(q));
    return true;
}

static hb_u16 uart_write(void *context, const hb_octet *octets, hb_u16 count)
{
    hb_host *host = context;
    hb_u16 accepted = 0;

    if (host->baud > 0u) {
        while (accepted < count
               && push(&host->to_host.going, (unsigned char)octets[accepted])) {
            accepted++;
        }
        return accepted;
    }
    while (accepted < count && waiting(&host->to_host.come) < QUEUE_OCTETS) {
        hand_to_host(host, (unsigned char)octets[accepted++]);
    }
    return accepted;
}

/* Ticks come from the caller's own loop, never in the middle of a poll. */
static void no_interrupts(void *context)
{
    (void)context;
}

hb_host *hb_host_create(uint16_t boots, uint32_t baud)
{
    hb_host *host = calloc(1, sizeof *host);
    hb_log_record *ring = calloc(RING_RECORDS, sizeof *ring);

    if (host == NULL || ring == NULL) {
        free(ring);
        free(host);
        return NULL;
    }
    host->baud = baud;
    open_direction(&host->to_board, QUEUE_OCTETS, baud > 0u ? RECEIVE_BUFFER : QUEUE_OCTETS);
    open_direction(&host->to_host, TRANSMIT_FIFO, QUEUE_OCTETS);
    const hb_hal hal = {
        .board = "host",
        .boots = boots,
        .adc = HB_SIMULATED_ADC,
        .dac = HB_SIMULATED_DAC,
        .ring = ring,
        .ring_records = RING_RECORDS,
        .context = host,
        .uart_read = uart_read,
        .uart_write = uart_write,
        .mask_control = no_interrupts,
        .unmask_control = no_interrupts,
    };
    hb_core_init(&host->core, &hal);
    hb_link_init(&host->link, &host->core);
    return host;
}

void hb_host_destroy(hb_host *host)
{
    free(host->core.log.ring);
    free(host);
}

void hb_host_tick(hb_host *host, const uint16_t *adc, int16_t *dac)
{
    hb_core_tick(&host->core, adc, dac);
    if (host->baud > 0u) {
        carry(host, &host->to_board);
        carry(host, &host->to_host);
    }
}

void hb_host_overrun(hb_host *host)
{
    hb_core_overrun(&host->core);
}

uint32_t hb_host_poll(hb_host *host)
{
    hb_link_poll(&host->link);
    return host->frame_ended ? waiting(&host->to_host.come) : 0u;
}

uint32_t hb_host_receive(hb_host *host, const unsigned char *octets, uint32_t count)
{
    queue *q = host->baud > 0u ? &host->to_board.going : &host->to_board.come;
    uint32_t taken = 0;

    while (taken < count && push(q, octets[taken])) {
        taken++;
    }
    return taken;
}

uint32_t hb_host_transmit(hb_host *host, unsigned char *octets, uint32_t capacity)
{
    queue *q = &host->to_host.come;
    uint32_t given = 0;

    while (given < capacity && waiting(q) > 0u) {
        octets[given++] = pop(q);
    }
    host->frame_ended = waiting(q) > 0u;
    return given;
}

const hb_core *hb_host_core(const hb_host *host)
{
    return &host->core;
}
