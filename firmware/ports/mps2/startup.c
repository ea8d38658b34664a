/* Vectors and reset of the Cortex-M4. */
#include <stdint.h>

#include "semihost.h"
#include "uart.h"

#define CPACR (*(volatile uint32_t *)0xE000ED88u)
#define CPACR_FPU_ON (0xFu << 20)

int main(void);
void mps2_reset(void);

extern uint32_t mps2_stack_top; /* three addresses from link.ld */
extern uint32_t mps2_bss_begin;
extern uint32_t mps2_bss_end;

void mps2_reset(void)
{
    CPACR |= CPACR_FPU_ON; /* off at reset; before the first float */
    __asm__ volatile("dsb\n\tisb" ::: "memory");
    for (uint32_t *word = &mps2_bss_begin; word != &mps2_bss_end; word++) {
        *word = 0;
    }
    semihost_exit(main());
}

/* Any exception except the UART's ends the emulator. */
static void fault(void)
{
    semihost_exit(1);
}

struct vectors {
    uint32_t *stack;
    void (*exception[15])(void);
    void (*interrupt[1])(void);
};

extern const struct vectors mps2_vectors;
__attribute__((section(".vectors"), used)) const struct vectors mps2_vectors = {
    &mps2_stack_top,
    {mps2_reset, fault, fault, fault, fault, fault, fault, fault, fault, fault, fault, fault, fault,
     fault, fault},
    {uart_receive_interrupt},
};
