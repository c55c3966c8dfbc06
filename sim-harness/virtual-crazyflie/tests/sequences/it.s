@ IT blocks: every length, taken and not, flags inside, and exceptions in the middle.

        function sv_call
        ldr     r1, [sp, #28]               @ the stacked xPSR
        log     "ipsr", r1
        cmp     r1, r1                      @ the handler's flags are its own
        bx      lr

        @ An undefined instruction in a block is passed over: so is its place in ITSTATE.
        function usage_fault
        ldr     r1, [sp, #28]
        log     "undf", r1
        ldr     r2, [sp, #24]
        adds    r2, r2, #2
        str     r2, [sp, #24]
        and     r2, r1, #0x06000000         @ IT<1:0>
        and     r3, r1, #0xFC00             @ IT<7:2>
        lsrs    r2, r2, #25
        orr     r2, r2, r3, lsr #8
        and     r3, r2, #0xE0
        lsls    r2, r2, #1
        and     r2, r2, #0x1F
        tst     r2, #0xF
        ite     eq
        moveq   r2, #0
        orrne   r2, r2, r3
        bic     r1, r1, #0x06000000
        bic     r1, r1, #0xFC00
        and     r3, r2, #3
        orr     r1, r1, r3, lsl #25
        and     r3, r2, #0xFC
        orr     r1, r1, r3, lsl #8
        str     r1, [sp, #28]
        bx      lr

        function irq0
        adds    r0, r0, #0                  @ clears C, sets Z or not
        note    "irq0"
        bx      lr

        function main
        push    {lr}
        movs    r4, #0
        movs    r5, #7
        cmp     r5, #7                      @ EQ
        it      eq
        addeq   r4, r4, #1
        itt     eq
        addeq   r4, r4, #2
        addeq   r4, r4, #4
        ite     eq
        addeq   r4, r4, #8
        addne   r4, r4, #16
        ittt    ne
        addne   r4, r4, #32
        addne   r4, r4, #64
        addne   r4, r4, #128
        itee    ne
        addne   r4, r4, #256
        addeq   r4, r4, #512
        addeq   r4, r4, #1024
        itete   eq
        addeq   r4, r4, #2048
        addne   r4, r4, #4096
        addeq   r4, r4, #8192
        addne   r4, r4, #16384
        itttt   eq
        addeq   r4, r4, #0x10000
        addeq   r4, r4, #0x20000
        addeq   r4, r4, #0x40000
        addeq   r4, r4, #0x80000
        log     "all ", r4

        @ 16-bit instructions leave the flags alone inside a block; comparisons do not, and what
        @ follows sees theirs.
        movs    r4, #0
        cmp     r4, #0
        itttt   eq
        addeq   r4, #1
        cmpeq   r4, #1
        cmpeq   r4, #2
        addeq   r4, #4
        log     "flag", r4
        mrs     r0, apsr
        log     "apsr", r0

        @ A branch ends a block.
        movs    r4, #0
        cmp     r4, #1
        itt     lt
        addlt   r4, #2
        blt     1f
        add     r4, #64
1:      add     r4, #1
        log     "brch", r4

        @ A table of conditions, in all flags.
        movs    r6, #0
2:      lsl     r0, r6, #28
        msr     apsr_nzcvq, r0
        mov     r4, #0
        it      eq
        orreq   r4, r4, #0x1
        it      cs
        orrcs   r4, r4, #0x2
        it      mi
        orrmi   r4, r4, #0x4
        it      vs
        orrvs   r4, r4, #0x8
        it      hi
        orrhi   r4, r4, #0x10
        it      ge
        orrge   r4, r4, #0x20
        it      gt
        orrgt   r4, r4, #0x40
        it      le
        orrle   r4, r4, #0x80
        it      ls
        orrls   r4, r4, #0x100
        it      lt
        orrlt   r4, r4, #0x200
        it      al
        orral   r4, r4, #0x400
        log     "cond", r4
        adds    r6, r6, #1
        cmp     r6, #16
        bne     2b

        @ SVC at each place of a block; what stands after it still knows its condition.
        movs    r4, #0
        cmp     r4, #0
        itttt   eq
        svceq   1
        addeq   r4, #1
        addeq   r4, #2
        addeq   r4, #4
        cmp     r4, #9
        itete   ne
        addne   r4, #8
        svceq   2
        svcne   3
        addeq   r4, #64
        ittee   ne
        addne   r4, #16
        svcne   4
        addeq   r4, #64
        svceq   5
        it      ne
        svcne   6
        itttt   ne
        addne   r4, #32
        addne   r4, #32
        addne   r4, #32
        svcne   7
        log     "svc ", r4

        @ Undefined instructions in a block, where their condition holds.
        poke    SHCSR, 0x00040000
        movs    r4, #0
        cmp     r4, #0
        itett   eq
        addeq   r4, #1
        addne   r4, r4, #64
        .inst.n 0xDE02                      @ UDF
        addeq   r4, #2
        ittt    eq
        .inst.n 0xDE03
        addeq   r4, #4
        .inst.n 0xDE04
        log     "udf ", r4

        @ An interrupt that is asked for in a block.
        poke    ISER, 1
        set     r0, ISPR
        movs    r1, #1
        movs    r4, #0
        cmp     r4, #0
        itttt   eq
        streq   r1, [r0]
        dsbeq
        isbeq
        addeq   r4, #1
        it      eq
        addeq   r4, #2
        log     "irq ", r4
        pop     {pc}
