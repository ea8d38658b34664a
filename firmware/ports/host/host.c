#include "host.h"

#include <stdlib.h>

#include "../simulated.h"

#define RING_RECORDS 1024u
#define QUEUE_OCTETS 4096u /* a power of two, because the counters wrap */

/* The tick with all that it calls in one function, which GCC compiles twice for glibc's loader to
 * choose from: with AVX2 the same bits take fewer instructions. */
#if defined(__x86_64__) && defined(__GLIBC__) && !defined(__clang__)
#define WHOLE __attribute__((flatten, target_clones("avx2", "default")))
#elif defined(__GNUC__)
#define WHOLE __attribute__((flatten))
#else
#define WHOLE
#endif

/* With a baud rate. */
#define TRANSMIT_FIFO 16u    /* as in the F28335's SCI */
#define RECEIVE_BUFFER 128u  /* hal.h requires 64 */
#define OCTET_BITS 10u       /* with start and stop bit */
/* A tick adds the baud rate to the credit; an octet costs this much. Exact in integers. */
#define OCTET_CREDIT (OCTET_BITS * HB_RATE_HZ)

typedef struct {
    unsigned char octet[QUEUE_OCTETS];
    uint32_t room; /* at most QUEUE_OCTETS */
    uint32_t written;
    uint32_t read;
} queue;

/* One direction of the line. */
typedef struct {
    queue pending; /* to be transmitted */
    queue arrived;
    uint32_t credit; /* for the next octet */
} direction;

HB_ASSERT(ring_size_is_valid, HB_RING_SIZE_IS_VALID(RING_RECORDS));

struct hb_host {
    hb_core core; /* without the ring: together they exceed the largest object of an AVR compiler */
    hb_link link;
    uint32_t baud; /* 0: octets take no time */
    direction to_board;
    direction to_host;
    bool frame_ended; /* among the octets that have arrived at the host */
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

static void open_direction(direction *line, uint32_t pending, uint32_t arrived)
{
    line->pending.room = pending;
    line->arrived.room = arrived;
}

static void hand_to_host(hb_host *host, unsigned char octet)
{
    if (push(&host->to_host.arrived, octet) && octet == 0u) {
        host->frame_ended = true;
    }
}

/* Transmits during one tick. An octet is lost where its receiver's queue is full, as on any UART.
 * Credit accumulates only while octets are pending. */
static void carry(hb_host *host, direction *line)
{
    line->credit = waiting(&line->pending) > 0u ? line->credit + host->baud : 0u;
    while (line->credit >= OCTET_CREDIT && waiting(&line->pending) > 0u) {
        const unsigned char octet = pop(&line->pending);
        line->credit -= OCTET_CREDIT;
        if (line == &host->to_host) {
            hand_to_host(host, octet);
        } else {
            push(&line->arrived, octet);
        }
    }
}

static bool uart_read(void *context, hb_octet *octet)
{
    queue *q = &((hb_host *)context)->to_board.arrived;

    if (waiting(q) == 0u) {
        return false;
    }
    /* The upper bits of a wider octet are undefined on a UART; set them, to test the masks. */
    *octet = (hb_octet) ~(0xFFu & ~(unsigned)pop(q));
    return true;
}

static hb_u16 uart_write(void *context, const hb_octet *octets, hb_u16 count)
{
    hb_host *host = context;
    hb_u16 accepted = 0;

    if (host->baud > 0u) {
        while (accepted < count
               && push(&host->to_host.pending, (unsigned char)octets[accepted])) {
            accepted++;
        }
        return accepted;
    }
    while (accepted < count && waiting(&host->to_host.arrived) < QUEUE_OCTETS) {
        hand_to_host(host, (unsigned char)octets[accepted++]);
    }
    return accepted;
}

/* The caller's loop makes the ticks, never during a poll. */
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

WHOLE void hb_host_tick(hb_host *host, const uint16_t *adc, int16_t *dac)
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
    return host->frame_ended ? waiting(&host->to_host.arrived) : 0u;
}

uint32_t hb_host_receive(hb_host *host, const unsigned char *octets, uint32_t count)
{
    queue *q = host->baud > 0u ? &host->to_board.pending : &host->to_board.arrived;
    uint32_t accepted = 0;

    while (accepted < count && push(q, octets[accepted])) {
        accepted++;
    }
    return accepted;
}

uint32_t hb_host_transmit(hb_host *host, unsigned char *octets, uint32_t capacity)
{
    queue *q = &host->to_host.arrived;
    uint32_t copied = 0;

    while (copied < capacity && waiting(q) > 0u) {
        octets[copied++] = pop(q);
    }
    host->frame_ended = waiting(q) > 0u;
    return copied;
}

uint32_t hb_host_needs_supply_off(const hb_host *host)
{
    const hb_steps *steps = &host->core.steps;

    return steps->count > 0u
        && steps->segment[steps->step[0].segment].valves == HB_VALVES_VENTING;
}

const hb_core *hb_host_core(const hb_host *host)
{
    return &host->core;
}
