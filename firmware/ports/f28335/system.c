/* Never compiled by TI's compiler, never run on hardware. */
#include "system.h"

#include "compiler.h"
#include "registers.h"

#define PLL_FACTOR 10u         /* x 10, then / 2 by HB_PLLSTS_HALF */
#define HISPCP_25_MHZ 3u       /* / 6: the ADC's clock */
#define LOSPCP_37_5_MHZ 2u     /* / 4 */
#define LOCK_COUNTS 5000u      /* of about 20 us each; the PLL locks within 4.4 ms (check) */
#define COUNTS_PER_MICROSECOND ((hb_u16)(HB_SYSCLK_HZ / 1000000UL))

void hb_modules_start(void)
{
    HB_ALLOW();
    hb_write(HB_HISPCP, HISPCP_25_MHZ);
    hb_write(HB_LOSPCP, LOSPCP_37_5_MHZ);
    hb_write(HB_PCLKCR0, HB_PCLKCR0_ADC | HB_PCLKCR0_SCIA | HB_PCLKCR0_MCBSPA);
    hb_write(HB_PCLKCR1, HB_PCLKCR1_EPWM1);
    hb_write(HB_PCLKCR3, HB_PCLKCR3_TIMER0 | HB_PCLKCR3_GPIO_IN);
    HB_PROTECT();

    hb_write(HB_TCR, HB_TCR_STOP);
    hb_write(HB_PRD, 0xFFFFu);
    hb_write(HB_PRDH, 0xFFFFu);
    hb_write(HB_TPR, COUNTS_PER_MICROSECOND - 1u);
    hb_write(HB_TPRH, 0u);
    hb_write(HB_TCR, HB_TCR_STOP | HB_TCR_RELOAD);
    hb_write(HB_TCR, 0u);
}

bool hb_clock_start(void)
{
    if ((hb_read(HB_PLLSTS) & HB_PLLSTS_NO_CLOCK) != 0u) {
        return false;
    }
    /* The PLL is changed with the divider off, and without the missing-clock detection, which would
     * take the change for a failure of the oscillator. */
    HB_ALLOW();
    hb_write(HB_PLLSTS, (hb_u16)(hb_read(HB_PLLSTS) & ~HB_PLLSTS_DIVSEL));
    hb_write(HB_PLLSTS, (hb_u16)(hb_read(HB_PLLSTS) | HB_PLLSTS_NO_WATCH));
    hb_write(HB_PLLCR, PLL_FACTOR);
    const hb_u16 start = hb_microseconds();
    bool locked = false;
    while (!locked && (hb_u16)(hb_microseconds() - start) <= LOCK_COUNTS) {
        locked = (hb_read(HB_PLLSTS) & HB_PLLSTS_LOCKED) != 0u;
    }
    hb_write(HB_PLLSTS, (hb_u16)(hb_read(HB_PLLSTS) & ~HB_PLLSTS_NO_WATCH));
    if (locked) {
        hb_write(HB_PLLSTS, (hb_u16)(hb_read(HB_PLLSTS) | HB_PLLSTS_HALF));
    }
    HB_PROTECT();
    return locked;
}

hb_u16 hb_microseconds(void)
{
    return (hb_u16)(0xFFFFu - hb_read(HB_TIM));
}

void hb_wait(hb_u16 microseconds)
{
    const hb_u16 start = hb_microseconds();

    while ((hb_u16)(hb_microseconds() - start) <= microseconds) {
    }
}

void hb_watchdog_start(void)
{
    hb_watchdog_service(); /* begins a full period */
    HB_ALLOW();
    hb_write(HB_SCSR, 0u); /* reset instead of interrupt */
    hb_write(HB_WDCR, HB_WDCR_ON);
    HB_PROTECT();
}

void hb_watchdog_service(void)
{
    HB_ALLOW();
    hb_write(HB_WDKEY, 0x0055u);
    hb_write(HB_WDKEY, 0x00AAu);
    HB_PROTECT();
}
