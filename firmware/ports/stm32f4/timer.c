/* Never run on hardware. */
#include "timer.h"

#include "clock.h"
#include "hal.h"
#include "registers.h"

/* A tick's first scan begins this long after the tick, so that its last scan ends before the next
 * one: the scans are 6.25 us apart, and each takes 5.3 us. */
#define SCAN_DELAY_PART 50u /* of the time between two scans: 0.12 us */

#define TICK_BIT (1u << (IRQ_TIM2 % 32))

void timer_start(void)
{
    TIM5->ARR = 0xFFFFFFFFu;
    TIM5->CR1 = TIM_CR1_CEN;
}

uint32_t timer_now(void)
{
    return TIM5->CNT;
}

uint32_t timer_counts(uint32_t microseconds)
{
    return clock_timer_hz / 1000000u * microseconds;
}

void timer_wait(uint32_t microseconds)
{
    const uint32_t start = timer_now();
    const uint32_t counts = timer_counts(microseconds);

    while (timer_now() - start <= counts) {
    }
}

void timer_start_supervision(void)
{
    SYSTICK->RVR = CLOCK_CPU_HZ / 1000u - 1u;
    SYSTICK->CVR = 0u; /* any write begins a period */
    SYSTICK->CSR = SYSTICK_CSR_ON_WITH_INTERRUPT;
}

void timer_start_ticks(void)
{
    const uint32_t tick = clock_timer_hz / HB_RATE_HZ;
    const uint32_t scan = tick / TIMER_SCANS;

    /* Both count the same clock, and a tick is exactly 16 scans: their distance never changes. */
    TIM3->CR2 = TIM_CR2_TRGO_AT_UPDATE;
    TIM3->ARR = scan - 1u;
    TIM3->CNT = scan - scan / SCAN_DELAY_PART;
    TIM2->ARR = tick - 1u;
    TIM2->DIER = TIM_DIER_UIE;
    NVIC_ISER[IRQ_TIM2 / 32] = TICK_BIT;
    TIM2->CR1 = TIM_CR1_CEN;
    TIM3->CR1 = TIM_CR1_CEN;
}

void timer_take_tick(void)
{
    TIM2->SR = ~TIM_SR_UIF;
}

bool timer_tick_passed(void)
{
    return (TIM2->SR & TIM_SR_UIF) != 0u;
}

void timer_mask(void)
{
    NVIC_ICER[IRQ_TIM2 / 32] = TICK_BIT;
    __asm__ volatile("dsb\n\tisb" ::: "memory"); /* no tick after this line */
}

void timer_unmask(void)
{
    __asm__ volatile("" ::: "memory");
    NVIC_ISER[IRQ_TIM2 / 32] = TICK_BIT;
}
