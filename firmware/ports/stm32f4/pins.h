/* Functions of the chip's pins. Never run on hardware. */
#ifndef STM32F4_PINS_H
#define STM32F4_PINS_H

#include "registers.h"

enum pin_mode { PIN_INPUT = 0, PIN_OUTPUT = 1, PIN_ALTERNATE = 2, PIN_ANALOG = 3 };

static inline void pin_set_mode(gpio_registers *port, uint32_t pin, enum pin_mode mode)
{
    port->MODER = (port->MODER & ~(3u << (2u * pin))) | ((uint32_t)mode << (2u * pin));
}

static inline void pin_set_alternate(gpio_registers *port, uint32_t pin, uint32_t function)
{
    const uint32_t shift = 4u * (pin % 8u);

    port->AFR[pin / 8u] = (port->AFR[pin / 8u] & ~(0xFu << shift)) | (function << shift);
    pin_set_mode(port, pin, PIN_ALTERNATE);
}

static inline void pin_pull_up(gpio_registers *port, uint32_t pin)
{
    port->PUPDR = (port->PUPDR & ~(3u << (2u * pin))) | (1u << (2u * pin));
}

static inline void pin_set_high(gpio_registers *port, uint32_t pin)
{
    port->BSRR = 1u << pin;
}

static inline void pin_set_low(gpio_registers *port, uint32_t pin)
{
    port->BSRR = 1u << (pin + 16u);
}

#endif
