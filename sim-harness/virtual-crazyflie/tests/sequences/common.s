@ What every program here begins with: vectors, a log, and the end.
@
@ Code lies at 0, data at 0x20000000. The log is pairs of words from 0x20001000: four letters, and
@ a value. Vector 7, which the architecture reserves, leads to the end.

        .syntax unified
        .cpu    cortex-m4
        .fpu    fpv4-sp-d16
        .thumb

        .equ    LOG_END, 0x20000000         @ where the next entry goes
        .equ    LOG, 0x20001000
        .equ    STACK, 0x20008000
        .equ    PROCESS_STACK, 0x20007000

        .equ    ICSR, 0xE000ED04
        .equ    VTOR, 0xE000ED08
        .equ    AIRCR, 0xE000ED0C
        .equ    SCR, 0xE000ED10
        .equ    CCR, 0xE000ED14
        .equ    SHPR1, 0xE000ED18
        .equ    SHPR2, 0xE000ED1C
        .equ    SHPR3, 0xE000ED20
        .equ    SHCSR, 0xE000ED24
        .equ    CFSR, 0xE000ED28
        .equ    HFSR, 0xE000ED2C
        .equ    BFAR, 0xE000ED38
        .equ    CPACR, 0xE000ED88
        .equ    STIR, 0xE000EF00
        .equ    FPCCR, 0xE000EF34
        .equ    FPCAR, 0xE000EF38
        .equ    FPDSCR, 0xE000EF3C
        .equ    ISER, 0xE000E100
        .equ    ICER, 0xE000E180
        .equ    ISPR, 0xE000E200
        .equ    ICPR, 0xE000E280
        .equ    IABR, 0xE000E300
        .equ    IPR, 0xE000E400
        .equ    SYST_CSR, 0xE000E010
        .equ    SYST_RVR, 0xE000E014
        .equ    SYST_CVR, 0xE000E018

        @ A handler that a program does not have is `unexpected`: see image.ld.
        .section .vectors, "a"
        .word   STACK
        .word   start
        .word   nmi
        .word   hard_fault
        .word   mem_manage
        .word   bus_fault
        .word   usage_fault
        .word   finish
        .word   0, 0, 0
        .word   sv_call
        .word   debug_monitor
        .word   0
        .word   pend_sv
        .word   sys_tick
        .word   irq0
        .word   irq1
        .word   irq2
        .word   irq3
        .word   irq4
        .word   irq5

        .macro  function name
        .global \name
        .thumb_func
        .type   \name, %function
\name:
        .endm

        @ Writes a register to the log. Nothing is changed by it, flags included; only the words
        @ below the stack pointer are.
        .macro  log tag, reg
        push    {r0, r1, r2, lr}
        mov     r0, \reg
        bl      write_log
        .ascii  "\tag"
        pop     {r0, r1, r2, lr}
        .endm

        @ The same for a constant of 16 bits.
        .macro  note tag, value=0
        push    {r0, r1, r2, lr}
        movw    r0, #\value
        bl      write_log
        .ascii  "\tag"
        pop     {r0, r1, r2, lr}
        .endm

        .macro  set reg, value
        movw    \reg, #:lower16:\value
        movt    \reg, #:upper16:\value
        .endm

        @ Stores a constant; r0 and r1 are lost.
        .macro  poke address, value
        set     r0, \address
        set     r1, \value
        str     r1, [r0]
        .endm

        .macro  poke8 address, value
        set     r0, \address
        movw    r1, #\value
        strb    r1, [r0]
        .endm

        @ Loads from a constant address.
        .macro  peek reg, address
        set     \reg, \address
        ldr     \reg, [\reg]
        .endm

        @ What was stored takes effect here at the latest.
        .macro  settle
        dsb
        isb
        .endm

        .text
        .thumb
        function write_log
        ldrh.w  r1, [lr, #-1]
        ldrh.w  r2, [lr, #1]
        orr     r1, r1, r2, lsl #16
        add     lr, lr, #4
        push    {r3}
        set     r3, LOG_END
        ldr     r2, [r3]
        str     r1, [r2]
        str     r0, [r2, #4]
        add     r2, r2, #8
        str     r2, [r3]
        pop     {r3}
        bx      lr

        function start
        poke    LOG_END, LOG
        bl      main
        b       finish

        function unexpected
        mrs     r4, ipsr
        log     "!exc", r4
        peek    r4, CFSR
        log     "cfsr", r4
        ldr     r4, [sp, #24]
        log     " at ", r4
        b       finish

        @ Whoever runs this without semihosting stops here and looks into memory.
        function finish
        sub     sp, sp, #16
        ldr     r1, =output
        str     r1, [sp]
        movs    r1, #4
        str     r1, [sp, #4]
        movs    r1, #3
        str     r1, [sp, #8]
        mov     r1, sp
        movs    r0, #1                      @ SYS_OPEN
        bkpt    0xAB
        str     r0, [sp]
        ldr     r1, =LOG
        str     r1, [sp, #4]
        ldr     r2, =LOG_END
        ldr     r2, [r2]
        subs    r2, r2, r1
        str     r2, [sp, #8]
        mov     r1, sp
        movs    r0, #5                      @ SYS_WRITE
        bkpt    0xAB
        ldr     r1, =0x20026
        movs    r0, #0x18                   @ SYS_EXIT
        bkpt    0xAB
        b       .
        .p2align 2
output: .asciz  ":tt"
        .p2align 2
        .ltorg
