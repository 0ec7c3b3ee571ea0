/* Start of a Cortex-M7 under QEMU's mps2-an500: vectors, and the floating-point unit before the C library starts. */
#include <stdint.h>

extern void _start(void);
extern char stack_top[];
void reset(void);
void fault(void);

void reset(void)
{
    *(volatile uint32_t *)0xE000ED88u |= 0xFu << 20; /* CPACR: full access to the unit */
    __asm__ volatile("dsb\n isb");
    _start();
}

void fault(void)
{
    static const uint32_t reason[2] = {0x20026u, 3u}; /* ADP_Stopped_ApplicationExit with status 3 */
    register uint32_t operation __asm__("r0") = 0x20u; /* SYS_EXIT_EXTENDED */
    register const uint32_t *words __asm__("r1") = reason;
    __asm__ volatile("bkpt 0xAB" : : "r"(operation), "r"(words) : "memory");
    for (;;) {
    }
}

union vector {
    char *stack;
    void (*handler)(void);
};
__attribute__((section(".vectors"), used)) static const union vector vectors[16] = {
    {stack_top}, {.handler = reset}, {.handler = fault}, {.handler = fault}, {.handler = fault}, {.handler = fault},
    {.handler = fault}, {0}, {0}, {0}, {0}, {.handler = fault}, {.handler = fault}, {0}, {.handler = fault}, {.handler = fault},
};
