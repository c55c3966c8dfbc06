@ LDREX, STREX, CLREX: what keeps the monitor and what clears it.

        .equ    PLACE, 0x20000100

        @ What a handler has loaded is not for the thread to store.
        function sv_call
        set     r0, PLACE
        ldrex   r1, [r0]
        bx      lr

        @ Nor the other way round.
        function irq0
        set     r0, PLACE
        ldr     r1, [r0]
        strex   r2, r1, [r0]
        log     "entr", r2
        bx      lr

        @ Exclusive accesses of its own do not help whom it interrupts.
        function irq1
        set     r0, PLACE + 8
        ldrex   r1, [r0]
        adds    r1, r1, #1
        strex   r2, r1, [r0]
        log     "hand", r2
        bx      lr

        function main
        push    {r4, r5, r6, lr}
        set     r4, PLACE
        movs    r0, #10
        str     r0, [r4]
        str     r0, [r4, #8]

        ldrex   r0, [r4]
        adds    r0, #1
        strex   r1, r0, [r4]
        log     "word", r1
        ldr     r0, [r4]
        log     " is ", r0

        @ The first STREX has taken the monitor.
        movs    r0, #99
        strex   r1, r0, [r4]
        log     "twic", r1
        ldr     r0, [r4]
        log     " is ", r0

        ldrex   r0, [r4]
        clrex
        strex   r1, r0, [r4]
        log     "clrx", r1

        ldrexb  r0, [r4]
        adds    r0, #1
        strexb  r1, r0, [r4]
        log     "byte", r1
        ldrexh  r0, [r4]
        adds    r0, #1
        strexh  r1, r0, [r4]
        log     "half", r1
        ldr     r0, [r4]
        log     " is ", r0

        @ With an offset.
        ldrex   r0, [r4, #8]
        adds    r0, #1
        strex   r1, r0, [r4, #8]
        log     "offs", r1
        ldr     r0, [r4, #8]
        log     " is ", r0

        @ An ordinary load, or a store elsewhere, is nothing to the monitor.
        ldrex   r0, [r4]
        ldr     r2, [r4, #4]
        str     r2, [r4, #4]
        strex   r1, r0, [r4]
        log     "near", r1

        @ Any exception clears it.
        ldrex   r0, [r4]
        svc     0
        strex   r1, r0, [r4]
        log     "svc ", r1

        poke    ISER, 3
        set     r5, ISPR
        movs    r6, #1
        ldrex   r0, [r4]
        str     r6, [r5]
        settle
        strex   r1, r0, [r4]
        log     "irq0", r1

        movs    r6, #2
        ldrex   r0, [r4]
        str     r6, [r5]
        settle
        strex   r1, r0, [r4]
        log     "irq1", r1
        ldr     r0, [r4, #8]
        log     " is ", r0

        @ A loop as compilers make it for an atomic addition.
        movs    r6, #0
1:      ldrex   r0, [r4, #12]
        mov     r0, r6
        strex   r1, r0, [r4, #12]
        cmp     r1, #0
        bne     1b
        adds    r6, #1
        cmp     r6, #5
        bne     1b
        ldr     r0, [r4, #12]
        log     "loop", r0
        pop     {r4, r5, r6, pc}
