/* AD5724R: words of 24 bits over SPI2. Channels A, B, C drive T, L1, L2 at +-10 V. Wiring: PB15 to
 * SDIN, PB13 to SCLK, PB12 to SYNC, LDAC low, BIN/2sCOMP low (codes are two's complement), the
 * released line (see emergency_stop.h) to CLR. Never run on hardware. */
#include "dac.h"

#include "../ad5724r.h"
#include "clock.h"
#include "pins.h"
#include "timer.h"

#define SYNC_PORT GPIOB
#define SYNC_PIN 12u
#define CLOCK_PIN 13u
#define DATA_PIN 15u
#define FUNCTION_SPI2 5u

#define OCTET_US 10u     /* timeout: an octet takes 0.8 us, 2 us before clock_start */

static bool becomes(uint32_t mask, uint32_t value)
{
    if ((SPI2->SR & mask) == value) {
        return true;
    }
    const uint32_t start = timer_now();
    const uint32_t counts = timer_counts(OCTET_US);
    while ((SPI2->SR & mask) != value) {
        if (timer_now() - start > counts) {
            return false;
        }
    }
    return true;
}

/* The word takes effect as SYNC rises. */
static bool send(uint32_t upper, uint32_t lower)
{
    const uint8_t octets[3] = {(uint8_t)upper, (uint8_t)(lower >> 8), (uint8_t)lower};
    bool sent = true;

    pin_set_low(SYNC_PORT, SYNC_PIN);
    for (uint32_t i = 0; i < 3u && sent; i++) {
        sent = becomes(SPI_SR_TXE, SPI_SR_TXE);
        SPI2->DR = octets[i];
    }
    sent = sent && becomes(SPI_SR_TXE, SPI_SR_TXE) && becomes(SPI_SR_BSY, 0u);
    pin_set_high(SYNC_PORT, SYNC_PIN);
    return sent;
}

bool dac_start(void)
{
    pin_set_high(SYNC_PORT, SYNC_PIN);
    pin_set_mode(SYNC_PORT, SYNC_PIN, PIN_OUTPUT);
    /* The clock idles high; the DAC samples at its falling edge. 42 MHz / 4 = 10.5 MHz of at most
     * 30. */
    SPI2->CR1 = SPI_CR1_SSM | SPI_CR1_SSI | SPI_CR1_CLOCK_BY_4 | SPI_CR1_MSTR | SPI_CR1_CPOL;
    SPI2->CR1 |= SPI_CR1_SPE;
    pin_set_alternate(GPIOB, CLOCK_PIN, FUNCTION_SPI2);
    pin_set_alternate(GPIOB, DATA_PIN, FUNCTION_SPI2);

    /* After a reset of the processor alone the DAC keeps its last codes. */
    if (!send(DAC_CLEAR, 0u) || !send(DAC_CONTROL, CLEAR_TO_0_V)
        || !send(DAC_RANGE | ALL_CHANNELS, PLUS_MINUS_10_V)
        || !send(DAC_REGISTER | ALL_CHANNELS, 0u) || !send(DAC_POWER, POWER_A_B_C_REFERENCE)) {
        return false;
    }
    timer_wait(POWER_UP_US);
    return send(DAC_REGISTER | ALL_CHANNELS, 0u);
}

bool dac_write(const hb_i16 codes[HB_VALVES])
{
    for (uint32_t channel = 0; channel < HB_VALVES; channel++) {
        /* 12 bits, left-justified in 16. */
        if (!send(DAC_REGISTER | channel, (uint16_t)((uint16_t)codes[channel] << 4))) {
            return false;
        }
    }
    return true;
}

void dac_clear(void)
{
    pin_set_high(SYNC_PORT, SYNC_PIN); /* ends a word that a failure cut off */
    (void)send(DAC_CLEAR, 0u);
    (void)send(DAC_REGISTER | ALL_CHANNELS, 0u);
}
