@ Exception entry and return with basic frames: what is stacked where, on which stack, with which
@ alignment, and where EXC_RETURN leads.

        @ Logs the frame, the stack, EXC_RETURN and CONTROL. With two in R7 it makes the thread
        @ privileged, on the main stack.
        function sv_call
        mov     r4, lr
        log     "lr  ", r4
        tst     lr, #4
        ite     eq
        moveq   r5, sp
        mrsne   r5, psp
        log     "sp  ", r5
        ldr     r4, [r5]
        log     "r0  ", r4
        ldr     r4, [r5, #4]
        log     "r1  ", r4
        ldr     r4, [r5, #8]
        log     "r2  ", r4
        ldr     r4, [r5, #12]
        log     "r3  ", r4
        ldr     r4, [r5, #16]
        log     "r12 ", r4
        ldr     r4, [r5, #20]
        log     "slr ", r4
        ldr     r4, [r5, #24]
        ldrh    r4, [r4]                    @ what it returns to
        log     "code", r4
        ldr     r4, [r5, #28]
        log     "xpsr", r4
        mrs     r4, control
        log     "ctrl", r4
        mrs     r4, ipsr
        log     "ipsr", r4
        @ What the handler leaves in the frame is what the thread gets.
        movw    r4, #0x1234
        str     r4, [r5, #4]
        movs    r0, #0xEE
        mov     r2, r0
        mov     r12, r0
        cmp     r7, #2
        itt     eq
        moveq   r7, #0
        msreq   control, r7
        bx      lr

        @ Asks for irq1, which is more urgent, from inside a handler.
        function irq0
        push    {r4, lr}
        poke    ISPR, 2
        settle
        note    "irq0"
        pop     {r4, pc}

        function irq1
        push    {r4, lr}
        log     "nest", lr
        ldr     r4, [sp, #36]
        ubfx    r4, r4, #0, #9
        log     "from", r4
        peek    r4, ICSR
        and     r4, r4, #0x800              @ RETTOBASE
        log     "base", r4
        ldmia   sp!, {r4, pc}

        .macro  call
        movs    r0, #0xA0
        movs    r1, #0xA1
        movs    r2, #0xA2
        movs    r3, #0xA3
        mov     r12, #0xAC
        movw    lr, #0xABCD
        set     r4, 0xB8000000
        msr     apsr_nzcvq, r4
        svc     0
        .hword  0xBF00                      @ NOP
        mrs     r4, apsr
        log     "apsr", r4
        log     "r0' ", r0
        log     "r1' ", r1
        log     "r2' ", r2
        log     "r12'", r12
        log     "lr' ", lr
        mov     r4, sp
        log     "sp' ", r4
        .endm

        function main
        mov     r9, sp
        movs    r7, #0
        note    "main"
        call
        @ One handler inside another.
        note    "two "
        poke    IPR, 0x00000080
        poke    ISER, 3
        poke    ISPR, 1
        settle
        @ A stack that is aligned to four only.
        note    "odd "
        sub     sp, sp, #4
        call
        @ CCR.STKALIGN cleared.
        note    "unal"
        poke    CCR, 0
        call
        poke    CCR, 0x200
        mov     sp, r9

        @ The thread on the process stack.
        note    "psp "
        set     r0, PROCESS_STACK
        msr     psp, r0
        movs    r0, #2
        msr     control, r0
        isb
        call
        note    "podd"
        sub     sp, sp, #4
        call
        @ And without privilege, which only a handler gives back.
        note    "user"
        movs    r0, #3
        msr     control, r0
        isb
        call
        movs    r0, #0
        msr     control, r0                 @ ignored
        isb
        mrs     r4, control
        log     "ctrl", r4
        mrs     r4, psp                     @ reads as zero
        log     "psp?", r4
        msr     primask, r0
        cpsid   i                           @ ignored
        movs    r7, #2
        svc     0
        mrs     r4, control
        log     "ctrl", r4
        b       finish
