/* Never run on hardware. */
#include "board.h"

#include "adc.h"
#include "boots.h"
#include "clock.h"
#include "dac.h"
#include "emergency_stop.h"
#include "led.h"
#include "link.h"
#include "supply.h"
#include "timer.h"
#include "uart.h"
#include "watchdog.h"

#define LATE_US 150u /* a tick and a half since the last one: a tick was lost */
/* The supervision detects a failure of the control interrupt, and that one of the idle loop, before
 * the watchdog's shortest time: the outputs are cut before the reset. "start" may block the idle loop
 * for 2 ms. */
#define DEAD_US 3000u
#define DEAD_TICKS 50u

#define RING_RECORDS 1024u
HB_ASSERT(ring_size_is_valid, HB_RING_SIZE_IS_VALID(RING_RECORDS));

static hb_log_record ring[RING_RECORDS];
static hb_core core;
static hb_link link;

static volatile uint32_t tick_begin;     /* time of the last tick */
static volatile uint32_t ticks;          /* completed */
static volatile uint32_t ticks_serviced; /* value of ticks when the watchdog was last serviced */
static uint32_t incomplete;              /* ticks in a row in which a conversion was missing */
static volatile bool excused;            /* the next tick may be late */
static bool at_rest;                     /* at the time control was masked */
static bool released;

static void mask_control(void *context)
{
    (void)context;
    timer_mask();
    at_rest = core.state != HB_STATE_RUNNING;
}

/* The core may mask the interrupt for longer than a tick at rest, but not while it runs. */
static void unmask_control(void *context)
{
    (void)context;
    if (at_rest) {
        excused = true;
    }
    timer_unmask();
}

void board_control_interrupt(void)
{
    static const hb_i16 neutral[HB_VALVES] = {0, 0, 0};
    hb_u16 words[HB_INPUTS];
    hb_i16 codes[HB_VALVES];
    const uint32_t now = timer_now();
    const bool late = now - tick_begin > timer_counts(LATE_US);

    timer_take_tick();
    tick_begin = now;
    if (late && !excused) {
        hb_core_overrun(&core);
    }
    const bool idle_lives = ticks - ticks_serviced < DEAD_TICKS;
    incomplete = adc_read(words) ? 0u : incomplete + 1u;
    if (!idle_lives || incomplete > 1u) {
        board_stop();
        return;
    }
    const bool pressed = emergency_stop_is_pressed();
    if (pressed && core.state == HB_STATE_RUNNING) {
        /* The core has no input for it; words of open inputs end the schedule in this tick. */
        for (hb_u16 i = 0; i < HB_INPUTS; i++) {
            words[i] = 0;
        }
    }
    hb_core_tick(&core, words, codes);
    if (!dac_write(codes)) {
        board_stop();
        return;
    }
    if (timer_tick_passed() && !excused) {
        hb_core_overrun(&core);
        (void)dac_write(neutral);
    }
    led_tick(core.state, pressed);
    excused = false;
    ticks++;
}

void board_supervision_interrupt(void)
{
    if (timer_now() - tick_begin > timer_counts(DEAD_US)) {
        board_stop();
    }
}

static bool start(void)
{
    emergency_stop_start();
    watchdog_start();
    led_start();
    timer_start();
    if (!dac_start() || !clock_start()) {
        return false;
    }
    supply_start();
    ticks = 0;
    ticks_serviced = 0;
    excused = true;
    const hb_hal hal = {
        .board = clock_board,
        .boots = boots_count(),
        .adc = ADC_SCALE,
        .dac = DAC_SCALE,
        .ring = ring,
        .ring_records = RING_RECORDS,
        .uart_read = uart_read,
        .uart_write = uart_write,
        .mask_control = mask_control,
        .unmask_control = unmask_control,
    };
    hb_core_init(&core, &hal);
    hb_link_init(&link, &core);
    uart_start();
    adc_start();
    if (supply_is_low()) {
        return false;
    }
    tick_begin = timer_now();
    timer_start_ticks();
    timer_start_supervision();
    return true;
}

static void idle(void)
{
    hb_link_poll(&link);
    /* Only if both are alive: the idle loop, and the control interrupt according to its count. */
    const uint32_t completed = ticks;
    if (completed != ticks_serviced) {
        ticks_serviced = completed;
        watchdog_service();
        if (!released) {
            released = true;
            outputs_release(); /* they have the codes of a tick */
        }
    }
    if (!uart_is_sending()) {
        __asm__ volatile("wfi"); /* until the next octet or tick */
    }
}

void board_run(void)
{
    clock_enable_peripherals();
    if (!start()) {
        board_stop();
    }
    for (;;) {
        idle();
    }
}

void board_stop(void)
{
    __asm__ volatile("cpsid i" ::: "memory");
    outputs_cut();
    dac_clear();
    for (;;) {
    }
}
