/* Never compiled by TI's compiler, never run on hardware. */
#include "adc.h"

#include "compiler.h"
#include "registers.h"
#include "system.h"

#define PASSES 8u
#define SLOTS 16u
#define PASS_US 10u /* timeout of a pass, which takes 1.3 us */
/* Window of (0 + 1) x 40 ns: 80 ns per conversion. Increase it for a sensor whose source impedance
 * is too high to charge the sampling capacitor in that time; each step adds 40 ns. */
#define WINDOW 0u

HB_ASSERT(a_pass_holds_each_input_twice, 2u * HB_INPUTS <= SLOTS);
HB_ASSERT(the_sum_is_the_mean_in_sixteenths, 2u * PASSES * 4095u == HB_ADC_FULL_SCALE);

void hb_adc_start(void)
{
    HB_ALLOW();
    HB_CALIBRATE_ADC();
    HB_PROTECT();
    hb_write(HB_ADCTRL1, HB_ADCTRL1_RESET);
    hb_wait(1u);
    hb_write(HB_ADCTRL3, HB_ADCTRL3_POWER); /* clock 25 MHz undivided, sequential sampling */
    hb_wait(5000u);
    hb_write(HB_ADCTRL1, HB_ADCTRL1_CASCADED | (WINDOW << HB_ADCTRL1_ACQ_PS));
    hb_write(HB_ADCMAXCONV, SLOTS - 1u);
    /* Inputs of the slots, four bits each, lowest first: A0 to A7, A0 to A7. */
    hb_write(HB_ADCCHSELSEQ1, 0x3210u);
    hb_write(HB_ADCCHSELSEQ1 + 1u, 0x7654u);
    hb_write(HB_ADCCHSELSEQ1 + 2u, 0x3210u);
    hb_write(HB_ADCCHSELSEQ1 + 3u, 0x7654u);
    hb_write(HB_ADCST, HB_ADCST_CLEAR_SEQ1);
    hb_write(HB_ADCTRL2, HB_ADCTRL2_RESET_SEQ1);
    hb_write(HB_ADCTRL2, HB_ADCTRL2_EPWM_SOCA | HB_ADCTRL2_INTERRUPT);
}

void hb_ticks_start(void)
{
    hb_write(HB_TBPHS, 0u);
    hb_write(HB_TBCTR, 0u);
    hb_write(HB_TBPRD, (hb_u16)(HB_SYSCLK_HZ / HB_RATE_HZ - 1UL));
    hb_write(HB_TBCTL, HB_TBCTL_UP);
    hb_write(HB_ETPS, HB_ETPS_SOCA_EACH);
    hb_write(HB_ETSEL, HB_ETSEL_SOCA_AT_PERIOD);
    hb_write(HB_ETCLR, HB_ET_SOCA);
    HB_ALLOW();
    hb_write(HB_PCLKCR0, (hb_u16)(hb_read(HB_PCLKCR0) | HB_PCLKCR0_TBCLKSYNC));
    HB_PROTECT();
}

static bool pass_is_over(void)
{
    const hb_u16 start = hb_microseconds();

    while ((hb_read(HB_ADCST) & HB_ADCST_INT_SEQ1) == 0u) {
        if ((hb_u16)(hb_microseconds() - start) > PASS_US) {
            return false;
        }
    }
    return true;
}

bool hb_adc_read(hb_u16 words[HB_INPUTS])
{
    bool converted = true;

    hb_write(HB_ETCLR, HB_ET_SOCA);
    for (hb_u16 i = 0; i < HB_INPUTS; i++) {
        words[i] = 0;
    }
    for (hb_u16 pass = 0; pass < PASSES && converted; pass++) {
        if (pass > 0u) {
            /* No interrupt; the flag marks the end of the pass. */
            hb_write(HB_ADCST, HB_ADCST_CLEAR_SEQ1);
            hb_write(HB_ADCTRL2, HB_ADCTRL2_RESET_SEQ1);
            hb_write(HB_ADCTRL2, HB_ADCTRL2_START);
        }
        converted = pass_is_over();
        for (hb_u16 i = 0; i < HB_INPUTS; i++) {
            words[i] = (hb_u16)(words[i] + hb_read((hb_u16)(HB_ADCRESULT + i))
                                + hb_read((hb_u16)(HB_ADCRESULT + HB_INPUTS + i)));
        }
    }
    hb_write(HB_ADCST, HB_ADCST_CLEAR_SEQ1);
    hb_write(HB_ADCTRL2, HB_ADCTRL2_RESET_SEQ1);
    hb_write(HB_ADCTRL2, HB_ADCTRL2_EPWM_SOCA | HB_ADCTRL2_INTERRUPT);
    return converted;
}

bool hb_tick_passed(void)
{
    return (hb_read(HB_ETFLG) & HB_ET_SOCA) != 0u;
}
