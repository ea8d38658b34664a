/* Never compiled by TI's compiler, never run on hardware. */
#include "dac.h"

#include "../ad5724r.h"
#include "compiler.h"
#include "registers.h"
#include "system.h"

/* GPIO20, 22 and 23 are McBSP pins; GPIO21 (MDRA) is not used, because nothing is read back. */
#define MUX_MCBSP 0xA200u
#define MUX_MCBSP_MASK 0xF300u
#define CLR_PIN 0x0040u /* GPIO6; its pull-up is off after reset */

#define CLOCK_DIVIDER 3u /* SCLK = LSPCLK / 4 = 9.4 MHz of at most 30 */
#define WORD_US 20u      /* timeout: a word takes 2.6 us, 51 us before the PLL runs */

static bool send(hb_u16 upper, hb_u16 lower)
{
    const hb_u16 start = hb_microseconds();

    while ((hb_read(HB_SPCR2) & HB_SPCR2_XRDY) == 0u) {
        if ((hb_u16)(hb_microseconds() - start) > WORD_US) {
            return false;
        }
    }
    hb_write(HB_DXR2, upper);
    hb_write(HB_DXR1, lower); /* starts the transmission */
    return true;
}

static void start_mcbsp(void)
{
    HB_ALLOW();
    hb_write(HB_GPAMUX2, (hb_u16)((hb_read(HB_GPAMUX2) & ~MUX_MCBSP_MASK) | MUX_MCBSP));
    HB_PROTECT();

    hb_write(HB_SPCR2, 0u); /* hold the module in reset */
    hb_write(HB_SPCR1, HB_SPCR1_CLKSTP);
    hb_write(HB_MFFINT, 0u);
    hb_write(HB_MCR2, 0u);
    hb_write(HB_MCR1, 0u);
    /* Data change at the rising clock edge, the DAC samples at the falling edge (check by
     * scope). */
    hb_write(HB_PCR, HB_PCR_SPI_MASTER);
    hb_write(HB_RCR2, HB_DELAY_1_BIT);
    hb_write(HB_RCR1, HB_WORDS_OF_24_BITS);
    hb_write(HB_XCR2, HB_DELAY_1_BIT);
    hb_write(HB_XCR1, HB_WORDS_OF_24_BITS);
    hb_write(HB_SRGR2, HB_SRGR2_LSPCLK);
    hb_write(HB_SRGR1, CLOCK_DIVIDER);
    hb_write(HB_SPCR2, HB_SPCR2_GRST);
    hb_wait(2u); /* more than two clocks of SCLK */
    hb_write(HB_SPCR2, HB_SPCR2_GRST | HB_SPCR2_XRST);
    hb_write(HB_SPCR1, HB_SPCR1_CLKSTP | HB_SPCR1_RRST);
    hb_write(HB_SPCR2, HB_SPCR2_GRST | HB_SPCR2_XRST | HB_SPCR2_FRST);
    hb_wait(2u);
}

bool hb_dac_start(void)
{
    HB_ALLOW();
    hb_write(HB_GPAMUX1, (hb_u16)(hb_read(HB_GPAMUX1) & ~0x3000u));
    hb_write(HB_GPACLEAR, CLR_PIN);
    hb_write(HB_GPADIR, (hb_u16)(hb_read(HB_GPADIR) | CLR_PIN));
    HB_PROTECT();
    start_mcbsp();

    /* After a reset of the processor alone the DAC keeps its last outputs. */
    if (!send(DAC_CLEAR, 0u) || !send(DAC_CONTROL, CLEAR_TO_0_V)
        || !send(DAC_RANGE | ALL_CHANNELS, PLUS_MINUS_10_V)
        || !send(DAC_REGISTER | ALL_CHANNELS, 0u) || !send(DAC_POWER, POWER_A_B_C_REFERENCE)) {
        return false;
    }
    hb_wait(POWER_UP_US);
    return send(DAC_REGISTER | ALL_CHANNELS, 0u);
}

void hb_dac_release(void)
{
    hb_write(HB_GPASET, CLR_PIN);
}

bool hb_dac_write(const hb_i16 codes[HB_VALVES])
{
    for (hb_u16 channel = 0; channel < HB_VALVES; channel++) {
        /* 12 bits, left-justified in 16. */
        const hb_u16 code = (hb_u16)((hb_u16)codes[channel] << 4);
        if (!send((hb_u16)(DAC_REGISTER | channel), code)) {
            return false;
        }
    }
    return true;
}

void hb_dac_clear(void)
{
    hb_write(HB_GPACLEAR, CLR_PIN);
    (void)send(DAC_CLEAR, 0u);
    (void)send(DAC_REGISTER | ALL_CHANNELS, 0u);
}
