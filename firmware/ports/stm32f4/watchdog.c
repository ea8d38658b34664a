/* Never run on hardware. */
#include "watchdog.h"

#include "registers.h"

#define COUNTS 80u /* of the oscillator divided by 4: 10 ms at its nominal 32 kHz */

void watchdog_start(void)
{
    IWDG_KR = IWDG_KR_START; /* the registers below take some periods of its oscillator */
    IWDG_KR = IWDG_KR_UNLOCK;
    IWDG_PR = IWDG_PR_BY_4;
    IWDG_RLR = COUNTS - 1u;
    IWDG_KR = IWDG_KR_SERVICE;
}

void watchdog_service(void)
{
    IWDG_KR = IWDG_KR_SERVICE;
}
