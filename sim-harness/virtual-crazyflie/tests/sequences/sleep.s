@ WFI, WFE, SEV, and SysTick. That a core wakes is told by what comes after; that it slept, by
@ what had been done by then.

        .equ    SLEEPONEXIT, 2
        .equ    SEVONPEND, 16

        function sys_tick
        adds    r8, r8, #1
        cmp     r8, r9                      @ so many, then no more
        bne     1f
        set     r0, SYST_CSR
        movs    r1, #0
        str     r1, [r0]
        set     r0, ICSR
        set     r1, 0x02000000
        str     r1, [r0]
        set     r0, ISPR
        str     r10, [r0]
1:      bx      lr

        function irq0
        note    "irq0"
        bx      lr

        function irq1
        poke    SCR, 0
        bx      lr

        @ SysTick so many times, from here on. With the last comes what is in R10.
        .macro  ticks count, flags=3
        mov     r8, #0
        mov     r9, #\count
        poke    SYST_CSR, 0
        poke    ICSR, 0x02000000            @ PENDSTCLR
        poke    SYST_RVR, 9999
        poke    SYST_CVR, 0
        poke    SYST_CSR, 4 + \flags
        .endm

        function main
        push    {r4, lr}
        movs    r0, #0
        mov     r10, r0
        poke    ISER, 1

        @ SysTick wakes WFI.
        ticks   1
        wfi
        log     "tick", r8
        ticks   5
1:      wfi
        cmp     r8, #5
        bne     1b
        log     "five", r8

        @ COUNTFLAG, without an interrupt, is cleared by reading.
        ticks   1, 1
2:      peek    r4, SYST_CSR
        tst     r4, #0x10000
        beq     2b
        log     "flag", r4
        poke    SYST_CSR, 4
        poke    SYST_CVR, 5                 @ any write clears
        peek    r4, SYST_CVR
        log     "cvr ", r4
        peek    r4, SYST_RVR
        log     "rvr ", r4

        @ With PRIMASK the interrupt wakes, and comes in afterwards.
        cpsid   i
        poke    ISPR, 1
        wfi
        note    "wfi1"
        cpsie   i
        isb
        ticks   1
        cpsid   i
        wfi
        log     "wfi2", r8
        peek    r4, ICSR
        and     r4, r4, #0x04000000         @ PENDSTSET
        log     "pend", r4
        cpsie   i
        isb
        log     "came", r8

        @ With BASEPRI only what is above it wakes: SysTick does.
        poke    IPR, 0x00000080
        movs    r0, #0x40
        msr     basepri, r0
        poke    ISPR, 1
        ticks   1
        wfi
        log     "base", r8
        movs    r0, #0
        msr     basepri, r0
        isb

        @ SEV, and the event register that it sets.
        sev
        wfe
        note    "sev "
        @ An exception's return sets it.
        poke    ISPR, 1
        settle
        wfe
        note    "ret "
        @ WFE until SysTick comes in.
        sev
        wfe
        ticks   3
3:      wfe
        cmp     r8, #3
        bne     3b
        log     "wfe ", r8

        @ What becomes pending is an event with SEVONPEND, masked and disabled as it may be.
        poke    SCR, SEVONPEND
        cpsid   i
        poke    ICER, 1
        sev
        wfe
        poke    ISPR, 1
        wfe
        note    "sevp"
        poke    ICPR, 1
        ticks   1
        wfe
        peek    r4, ICSR
        and     r4, r4, #0x04000000
        log     "pend", r4
        cpsie   i
        isb
        log     "came", r8
        poke    SCR, 0
        poke    ISER, 3

        @ SLEEPONEXIT: after irq0 it sleeps on, through two SysTicks, until irq1 ends that. Only then
        @ the thread sees what R8 is.
        mov     r10, #2
        cpsid   i
        poke    SCR, SLEEPONEXIT
        poke    ISPR, 1
        ticks   2
        cpsie   i
        isb
        log     "slep", r8
        pop     {r4, pc}
