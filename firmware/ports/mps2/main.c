/* The firmware on an emulated Cortex-M4 (QEMU, machine mps2-an386), in lock-step with a bench that
 * is simulated outside of it: processor in the loop (PIL).
 *
 * The protocol uses UART0. Converter words and DAC codes use semihosting: the program that
 * simulates the bench sends orders to the emulator's standard input and waits for the answer to
 * each. An order is one tick, one iteration of the idle loop, or the reception of octets. The control tick is
 * therefore called from the main loop, not from an interrupt; it is never late and never interrupts
 * a poll. This port demonstrates that the core gives the same result on this processor as on the
 * host, bit for bit, and counts its instructions. It demonstrates nothing about timing.
 *
 * The reception order waits for all octets that the host has sent, and every order ends after all
 * octets for the host have been sent. Nothing happens between orders. Thus the same orders give the
 * same answers, whatever the timing of the emulator's threads.
 */
#include "../simulated.h"
#include "link.h"
#include "semihost.h"
#include "uart.h"

#define MARK 0x4842u /* distinguishes an answer from the output of another program */

enum { ORDER_TICK = 1, ORDER_POLL = 2, ORDER_RECEIVE = 3 };

/* As on the semihosting link: little-endian, without padding. */
typedef struct {
    uint32_t code;
    uint32_t uart_octets; /* sent to UART0 since reset */
    uint16_t adc[HB_INPUTS];
} order;

typedef struct {
    uint16_t mark;
    int16_t dac[HB_VALVES];
    uint32_t clocks; /* of the SysTick during the order */
} answer;

HB_ASSERT(order_has_no_padding, sizeof(order) == 4u + 4u + 2u * HB_INPUTS);
HB_ASSERT(answer_has_no_padding, sizeof(answer) == 2u + 2u * HB_VALVES + 4u);

/* Counts down at 25 MHz of emulated time. */
#define SYSTICK_CONTROL (*(volatile uint32_t *)0xE000E010u)
#define SYSTICK_RELOAD (*(volatile uint32_t *)0xE000E014u)
#define SYSTICK_NOW (*(volatile uint32_t *)0xE000E018u)
#define SYSTICK_ON_WITHOUT_INTERRUPT 5u
#define SYSTICK_MASK 0xFFFFFFu

#define RING_RECORDS 1024u
HB_ASSERT(ring_size_is_valid, HB_RING_SIZE_IS_VALID(RING_RECORDS));

static hb_core core;
static hb_link link;
static hb_log_record ring[RING_RECORDS];

static bool uart_read(void *context, hb_octet *octet)
{
    (void)context;
    return uart_take(octet);
}

static hb_u16 uart_write(void *context, const hb_octet *octets, hb_u16 count)
{
    hb_u16 accepted = 0;

    (void)context;
    while (accepted < count && uart_put(octets[accepted])) {
        accepted++;
    }
    return accepted;
}

/* The main loop makes the ticks, never during a poll. */
static void no_interrupts(void *context)
{
    (void)context;
}

static void execute(const order *todo, answer *done)
{
    const uint32_t begin = SYSTICK_NOW;

    switch (todo->code) {
    case ORDER_TICK:
        hb_core_tick(&core, todo->adc, done->dac);
        break;
    case ORDER_POLL:
        hb_link_poll(&link);
        break;
    case ORDER_RECEIVE:
        uart_await(todo->uart_octets);
        break;
    default:
        break;
    }
    done->clocks = (begin - SYSTICK_NOW) & SYSTICK_MASK;
    uart_flush(); /* not counted, because it waits for the host */
}

int main(void)
{
    const hb_hal hal = {
        .board = "mps2",
        .boots = 1,
        .adc = HB_SIMULATED_ADC,
        .dac = HB_SIMULATED_DAC,
        .ring = ring,
        .ring_records = RING_RECORDS,
        .uart_read = uart_read,
        .uart_write = uart_write,
        .mask_control = no_interrupts,
        .unmask_control = no_interrupts,
    };
    const int32_t input = semihost_open_input();
    const int32_t output = semihost_open_output();
    order todo;
    answer done = {MARK, {0}, 0};

    SYSTICK_RELOAD = SYSTICK_MASK;
    SYSTICK_NOW = 0; /* any write restarts it */
    SYSTICK_CONTROL = SYSTICK_ON_WITHOUT_INTERRUPT;
    uart_init();
    hb_core_init(&core, &hal);
    hb_link_init(&link, &core);

    while (semihost_read(input, &todo, sizeof todo)) {
        execute(&todo, &done);
        if (!semihost_write(output, &done, sizeof done)) {
            return 1;
        }
    }
    return 0; /* the simulation has ended */
}
