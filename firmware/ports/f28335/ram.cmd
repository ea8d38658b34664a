/* The whole firmware in RAM, to be loaded by the serial boot ROM or a debugger.
 * Never linked by TI's linker.
 *
 * Memory of an F28335: M0 0x0000-0x03FF, M1 0x0400-0x07FF, L0-L3 0x8000-0xBFFF, L4-L7
 * 0xC000-0xFFFF. The ROM keeps its stack at 0x0002-0x004F. RAM is the same memory on both pages,
 * so each part is named on one page only. */
-e hb_codestart
-stack 0x400

/* Nothing to copy (main.c). */
_hb_load_start = 0;
_hb_run_start = 0;
_hb_load_size = 0;

MEMORY
{
PAGE 0:
    BEGIN   : origin = 0x000000, length = 0x000002  /* "boot to SARAM" begins here too */
    PROGRAM : origin = 0x008000, length = 0x002800  /* L0, L1, half of L2 */
PAGE 1:
    KEPT    : origin = 0x000050, length = 0x0003B0  /* M0 */
    STACK   : origin = 0x000400, length = 0x000400  /* M1 */
    DATA    : origin = 0x00A800, length = 0x001800  /* half of L2, L3 */
    LOG     : origin = 0x00C000, length = 0x004000  /* L4 to L7 */
}

SECTIONS
{
    codestart : > BEGIN,   PAGE = 0
    startup   : > PROGRAM, PAGE = 0
    .text     : > PROGRAM, PAGE = 0
    .cinit    : > PROGRAM, PAGE = 0
    .pinit    : > PROGRAM, PAGE = 0
    .switch   : > PROGRAM, PAGE = 0
    .reset    : > PROGRAM, PAGE = 0, TYPE = DSECT   /* the ROM's is used */

    hb_kept   : > KEPT,    PAGE = 1                 /* startup must not clear it */
    .stack    : > STACK,   PAGE = 1
    .ebss     : > DATA,    PAGE = 1
    .econst   : > DATA,    PAGE = 1
    .esysmem  : > DATA,    PAGE = 1
    hb_log    : > LOG,     PAGE = 1
}
