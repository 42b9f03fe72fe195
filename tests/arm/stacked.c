/* How many bytes an interrupt stacks where floats were in use: answered as the exit status of the emulator, in words. */
#include <stdint.h>

#define REGISTER(address) (*(volatile uint32_t *)(address))

extern uint32_t top[];
static uint32_t stacked;
void start(void);
void interrupt(void);

__attribute__((section(".vectors"), used)) static void (*const vectors[16])(void) = {
    (void (*)(void))(uintptr_t)top, start, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, interrupt, 0,
};

/* The stack pointer of the interrupt, before its code takes any: naked, so nothing is pushed. r4 holds the one before. */
__attribute__((naked)) void interrupt(void) {
    __asm__ volatile("mov r1, sp\n\tsubs r1, r4, r1\n\tstr r1, [%0]\n\tbx lr" : : "r"(&stacked) : "r1");
}

void start(void) {
    REGISTER(0xE000ED88u) |= 0xFu << 20; /* FPU on */
    __asm__ volatile("dsb\n\tisb\n\t.fpu fpv4-sp-d16\n\tvmov.f32 s0, #1.0\n\t"
                     "mov r4, sp\n\tsub sp, sp, %1\n\tsub r4, r4, %1\n\t"
                     "str %2, [%0]\n\tdsb\n\tisb\n\tadd sp, sp, %1"
                     : : "r"(0xE000ED04u), "I"(MISALIGNED), "r"(1u << 28) : "r4", "memory");
    const uint32_t block[2] = {0x20026u, stacked};
    register uint32_t r0 __asm__("r0") = 0x20u;
    register const uint32_t *r1 __asm__("r1") = block;
    __asm__ volatile("bkpt 0xAB" : : "r"(r0), "r"(r1) : "memory");
    for (;;) {
    }
}
