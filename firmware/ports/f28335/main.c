/* Last step of the startup. Never compiled by TI's compiler, never run on hardware. */
#include "board.h"

int main(void);

/* Load and run address of the program, as addresses of symbols from the linker. The flash image
 * copies all except this file and TI's library to RAM; the RAM image copies nothing. */
extern const hb_u16 hb_load_start[];
extern hb_u16 hb_run_start[];
extern const hb_u16 hb_load_size[]; /* its address is the size in words */

int main(void)
{
    const hb_u16 words = (hb_u16)(uintptr_t)hb_load_size;

    for (hb_u16 i = 0; i < words; i++) {
        hb_run_start[i] = hb_load_start[i];
    }
    if (!hb_board_start()) {
        hb_board_stop();
    }
    for (;;) {
        hb_board_idle();
    }
}
