/* Startup's last step. Never compiled by TI's compiler, never run on hardware. */
#include "board.h"

int main(void);

/* Where the linker put the program and where it runs, by the addresses of symbols that it makes.
 * From flash all but this file and TI's library runs in RAM, with the timing of the RAM image. In
 * the RAM image there is nothing to copy. */
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
