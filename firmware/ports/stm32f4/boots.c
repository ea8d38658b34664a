/* Never run on hardware. */
#include "boots.h"

#include "crc.h"

#define ENTROPY_WORDS 256u

/* In a section that the reset does not clear. volatile: their initial values come from no
 * program. */
#define KEPT __attribute__((section(".kept")))
static KEPT volatile hb_u16 kept[2]; /* count, its complement */
static KEPT volatile hb_u16 entropy[ENTROPY_WORDS];

hb_u16 boots_count(void)
{
    hb_u16 count = kept[0];

    if ((count ^ kept[1]) == 0xFFFFu) {
        count++;
    } else {
        count = 0;
        for (uint32_t i = 0; i < ENTROPY_WORDS; i++) {
            count = hb_crc_u16(count, entropy[i]);
        }
    }
    kept[0] = count;
    kept[1] = (hb_u16)~count;
    return count;
}
