/* Never compiled by TI's compiler, never run on hardware. */
#include "board.h"

#include "adc.h"
#include "boots.h"
#include "dac.h"
#include "interrupts.h"
#include "link.h"
#include "registers.h"
#include "system.h"
#include "uart.h"

#define LATE_US 150u  /* a tick and a half since the last one: a tick was lost */
/* Control interrupt and idle loop each detect a failure of the other before the watchdog's time, so
 * that the valves are neutral before the reset. "start" may block the idle loop for 2 ms. */
#define DEAD_US 3000u
#define DEAD_TICKS 50u

/* 16 384 words of 16 bits: all of L4 to L7. */
#ifndef RING_RECORDS
#define RING_RECORDS 1024u
#endif
HB_ASSERT(ring_size_is_valid, HB_RING_SIZE_IS_VALID(RING_RECORDS));
HB_ASSERT(ring_fits_l4_to_l7, RING_RECORDS * HB_RECORD_WORDS <= 16384u);

#ifdef __TMS320C28XX__
#pragma DATA_SECTION(log_ring, "hb_log")
#endif
static hb_log_record log_ring[RING_RECORDS];
static hb_core core;
static hb_link link;

static volatile hb_u16 tick_us;        /* start of the last tick */
static volatile hb_u16 ticks;          /* completed */
static volatile hb_u16 ticks_serviced; /* value of ticks when the watchdog was last serviced */
static volatile bool excused;          /* the next tick may be late */
static bool at_rest;                   /* at the time control was masked */

/* Handler of all unexpected interrupts: illegal instruction, NMI, traps. */
static HB_INTERRUPT void unexpected(void)
{
    hb_board_stop();
}

static HB_INTERRUPT void receive(void)
{
    hb_uart_receive();
    hb_receive_handled();
}

static HB_INTERRUPT void control(void)
{
    static const hb_i16 neutral[HB_VALVES] = {0, 0, 0};
    hb_u16 words[HB_INPUTS];
    hb_i16 codes[HB_VALVES];
    const hb_u16 now = hb_microseconds();
    const bool late = (hb_u16)(now - tick_us) > LATE_US;

    tick_us = now;
    if (late && !excused) {
        hb_core_overrun(&core);
    }
    const bool idle_lives = (hb_u16)(ticks - ticks_serviced) < DEAD_TICKS;
    if (!idle_lives || !hb_adc_read(words)) {
        hb_board_stop();
        return;
    }
    hb_core_tick(&core, words, codes);
    if (!hb_dac_write(codes)) {
        hb_board_stop();
        return;
    }
    if (hb_tick_passed() && !excused) {
        hb_core_overrun(&core);
        (void)hb_dac_write(neutral);
    }
    excused = false;
    ticks = (hb_u16)(ticks + 1u);
    hb_control_handled();
}

static void mask_control(void *context)
{
    (void)context;
    hb_mask_control();
    at_rest = core.state != HB_STATE_RUNNING;
}

/* The core may mask the interrupt for longer than a tick at rest, but not while it runs. */
static void unmask_control(void *context)
{
    (void)context;
    if (at_rest) {
        excused = true;
    }
    hb_unmask_control();
}

bool hb_board_start(void)
{
    HB_DISABLE_INTERRUPTS();
    HB_FLOAT_FLAGS();
    hb_modules_start();
    if (!hb_dac_start() || !hb_clock_start()) {
        hb_dac_clear();
        return false;
    }
    ticks = 0;
    ticks_serviced = 0;
    excused = true;
    const hb_hal hal = {
        .board = "f28335",
        .boots = hb_boots(),
        .adc = HB_ADC_SCALE,
        .dac = HB_DAC_SCALE,
        .ring = log_ring,
        .ring_records = RING_RECORDS,
        .uart_read = hb_uart_read,
        .uart_write = hb_uart_write,
        .mask_control = mask_control,
        .unmask_control = unmask_control,
    };
    hb_core_init(&core, &hal);
    hb_link_init(&link, &core);
    hb_uart_start();
    hb_adc_start();
    hb_interrupts_start(control, receive, unexpected);
    hb_dac_release();
    hb_watchdog_start();
    hb_ticks_start();
    tick_us = hb_microseconds();
    HB_ENABLE_INTERRUPTS();
    return true;
}

void hb_board_idle(void)
{
    hb_uart_recover();
    hb_link_poll(&link);
    /* Only if both are alive: the idle loop, and the control interrupt according to its count. */
    if (ticks != ticks_serviced) {
        ticks_serviced = ticks;
        hb_watchdog_service();
    }
    const hb_u16 since = tick_us; /* read first; a tick in between only shortens the time */
    if ((hb_u16)(hb_microseconds() - since) > DEAD_US) {
        hb_board_stop();
    }
}

void hb_board_stop(void)
{
    HB_DISABLE_INTERRUPTS();
    hb_dac_clear();
    hb_watchdog_start(); /* it may still be off */
    HB_HANG();
}
