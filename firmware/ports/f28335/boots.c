/* Never compiled by TI's compiler, never run on hardware. */
#include "boots.h"

#include "crc.h"

#define ENTROPY_WORDS 256u

/* In a section that startup does not initialise. volatile: their initial values come from no
 * program. */
#ifdef __TMS320C28XX__
#pragma DATA_SECTION(hb_boots_kept, "hb_kept")
#pragma DATA_SECTION(hb_boots_entropy, "hb_kept")
#endif
volatile hb_u16 hb_boots_kept[2]; /* count, its complement */
volatile hb_u16 hb_boots_entropy[ENTROPY_WORDS];

hb_u16 hb_boots(void)
{
    hb_u16 count = hb_boots_kept[0];
    const hb_u16 complement = hb_boots_kept[1];

    if ((count ^ complement) == 0xFFFFu) {
        count = (hb_u16)(count + 1u);
    } else {
        count = 0;
        for (hb_u16 i = 0; i < ENTROPY_WORDS; i++) {
            count = hb_crc_u16(count, hb_boots_entropy[i]);
        }
    }
    hb_boots_kept[0] = count;
    hb_boots_kept[1] = (hb_u16)~count;
    return count;
}
