/* Vectors and reset. Never run on hardware. */
#include <stdint.h>

#include "board.h"
#include "registers.h"
#include "uart.h"

typedef void (*vector)(void);

enum {
    VECTOR_SYSTICK = 15,
    VECTOR_TIM2 = 16 + IRQ_TIM2,
    VECTOR_USART2 = 16 + IRQ_USART2,
    VECTORS = 16 + IRQ_COUNT
};

extern uint32_t stack_top; /* three addresses from link.ld */
extern uint32_t bss_begin;
extern uint32_t bss_end;

void reset(void);

__attribute__((noreturn)) void reset(void)
{
    SCB_CPACR |= SCB_CPACR_FPU; /* off at reset; before the first float */
    __asm__ volatile("dsb\n\tisb" ::: "memory");
    for (uint32_t *word = &bss_begin; word != &bss_end; word++) {
        *word = 0;
    }
    NVIC_IPR[IRQ_TIM2] = 0x10u; /* all others interrupt the control */
    board_run();
    for (;;) {
    }
}

/* Faults, loss of the clock or the supply, and interrupts that nobody enabled. Begins with an empty
 * stack, because the old one may be the fault's cause. */
__attribute__((naked)) static void unexpected(void)
{
    __asm__ volatile("cpsid i\n\t"
                     "ldr r0, =stack_top\n\t"
                     "msr msp, r0\n\t"
                     "b board_stop\n\t"
                     ".ltorg");
}

__attribute__((section(".vectors"), used)) static const vector vectors[VECTORS] = {
    [0] = (vector)(uintptr_t)&stack_top,
    [1] = reset,
    [2 ... VECTOR_SYSTICK - 1] = unexpected,
    [VECTOR_SYSTICK] = board_supervision_interrupt,
    [VECTOR_SYSTICK + 1 ... VECTOR_TIM2 - 1] = unexpected,
    [VECTOR_TIM2] = board_control_interrupt,
    [VECTOR_TIM2 + 1 ... VECTOR_USART2 - 1] = unexpected,
    [VECTOR_USART2] = uart_receive_interrupt,
    [VECTOR_USART2 + 1 ... VECTORS - 1] = unexpected,
};
