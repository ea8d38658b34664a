/* Never run on hardware. */
#include "led.h"

#include "hal.h"
#include "pins.h"

/* A second in 16 parts, the first in the lowest bit. */
#define SHORT 0x0001u
#define TWO_SHORT 0x0005u
#define FOUR 0x3333u
#define ON 0xFFFFu
#define PARTS 16u

static uint32_t ticks;
static uint32_t part;
static bool lit;

void led_start(void)
{
    ticks = 0;
    part = 0;
    lit = false;
    pin_set_mode(GPIOA, 5u, PIN_OUTPUT);
    pin_set_mode(GPIOC, 8u, PIN_OUTPUT);
}

static uint32_t pattern(hb_u16 state, bool emergency_stop)
{
    if (emergency_stop) {
        return TWO_SHORT;
    }
    switch (state) {
    case HB_STATE_RUNNING:
        return ON;
    case HB_STATE_FAULT:
        return FOUR;
    default:
        return SHORT;
    }
}

void led_tick(hb_u16 state, bool emergency_stop)
{
    if (++ticks >= HB_RATE_HZ / PARTS) {
        ticks = 0;
        part = (part + 1u) % PARTS;
    }
    const bool on = (pattern(state, emergency_stop) >> part & 1u) != 0u;
    if (on != lit) {
        lit = on;
        GPIOA->BSRR = on ? 1u << 5 : 1u << 21;
        GPIOC->BSRR = on ? 1u << 8 : 1u << 24;
    }
}
