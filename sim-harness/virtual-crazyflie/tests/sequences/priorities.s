@ Who comes in, when, and in what order: priorities, grouping, masks, pending by software,
@ tail-chaining, late arrival.

        .macro  handler name, exception
        function \name
        push    {r4, r5, r6, lr}
        mrs     r4, ipsr
        log     "in  ", r4
        log     "lr  ", lr
        movs    r5, #\exception
        bl      orders
        log     "out ", r5
        pop     {r4, r5, r6, pc}
        .endm

        handler irq0, 16
        handler irq1, 17
        handler irq2, 18
        handler irq3, 19
        handler pend_sv, 14
        handler sv_call, 11

        @ R8 is an exception that has orders, R9 where it stores R10: it does so once. Whether an
        @ interrupt is pending that is masked, ICSR.ISRPENDING, is left out.
        function orders
        cmp     r8, r5
        it      ne
        bxne    lr
        mov     r8, #0
        str     r10, [r9]
        settle
        mov     r12, lr
        peek    r6, ICSR
        bic     r6, r6, #0x00400000
        log     "icsr", r6
        peek    r6, IABR
        log     "iabr", r6
        bx      r12

        .macro  order who, where, what
        mov     r8, #\who
        set     r9, \where
        set     r10, \what
        .endm

        .macro  pending
        peek    r4, ISPR
        log     "ispr", r4
        .endm

        .macro  release
        cpsie   i
        isb
        .endm

        function main
        push    {r4, lr}
        movs    r0, #0
        mov     r8, r0
        poke    ISER, 0xF
        poke    IPR, 0x60402080             @ irq0 80, irq1 20, irq2 40, irq3 60

        @ By number where priorities are equal, by priority where not; each by tail-chaining.
        note    "ordr"
        cpsid   i
        poke    ISPR, 0xF
        pending
        release
        pending
        note    "same"
        poke    IPR, 0x40404040
        cpsid   i
        poke    ISPR, 0xC
        poke    ISPR, 0x3
        release
        poke    IPR, 0x60402080

        @ From a handler: what is higher comes at once, what is not comes after.
        note    "high"
        order   16, ISPR, 2
        poke    ISPR, 1
        settle
        note    "low "
        order   17, ISPR, 1
        poke    ISPR, 2
        settle
        note    "self"
        order   17, ISPR, 2
        poke    ISPR, 2
        settle
        note    "equl"
        poke    IPR, 0x60404040
        order   17, ISPR, 1
        poke    ISPR, 2
        settle
        poke    IPR, 0x60402080

        @ What is in one group does not preempt, and is still first in its turn.
        note    "grup"
        poke    AIRCR, 0x05FA0500           @ two bits of group, 7:6
        poke    IPR, 0x50607080             @ irq1 70, irq2 60, irq3 50: all in group 40
        order   17, ISPR, 0xC
        poke    ISPR, 2
        settle
        peek    r4, AIRCR
        log     "airc", r4
        poke    AIRCR, 0x05FA0000
        poke    AIRCR, 0x12340700           @ without the key: ignored
        peek    r4, AIRCR
        log     "airc", r4
        poke    IPR, 0x60402080

        @ STIR, PendSV and SVC.
        note    "stir"
        poke    STIR, 3
        settle
        note    "psv "
        poke    SHPR3, 0x00F00000           @ PendSV lowest
        poke    ICSR, 0x10000000
        settle
        note    "svc "
        poke    SHPR2, 0x30000000
        svc     0
        @ A handler that asks for PendSV: that comes last.
        note    "last"
        order   18, ICSR, 0x10000000
        cpsid   i
        poke    ISPR, 0xC
        release
        @ PendSV that asks for interrupts is interrupted.
        note    "bott"
        order   14, ISPR, 5
        poke    ICSR, 0x10000000
        settle

        @ Taken back before it could come.
        note    "clr "
        cpsid   i
        poke    ISPR, 3
        poke    ICPR, 1
        poke    ICSR, 0x10000000
        poke    ICSR, 0x08000000
        pending
        release
        @ Pending while disabled, then enabled.
        note    "dis "
        poke    ICER, 4
        poke    ISPR, 4
        settle
        pending
        peek    r4, ISER
        log     "iser", r4
        poke    ISER, 4
        settle
        pending

        @ BASEPRI.
        note    "bpri"
        movs    r0, #0x40
        msr     basepri, r0
        isb
        poke    ISPR, 0xF                   @ irq1 only
        settle
        pending
        movs    r0, #0x50
        msr     basepri_max, r0             @ would lower it: ignored
        mrs     r4, basepri
        log     "bpri", r4
        movs    r0, #0x30
        msr     basepri_max, r0
        mrs     r4, basepri_max
        log     "bpri", r4
        movs    r0, #0
        msr     basepri_max, r0             @ zero: ignored
        mrs     r4, basepri
        log     "bpri", r4
        movs    r0, #0x60
        msr     basepri, r0                 @ irq2, not irq3
        isb
        pending
        movs    r0, #0
        msr     basepri, r0
        isb
        pending

        @ PRIMASK and FAULTMASK.
        note    "mask"
        cpsid   i
        mrs     r4, primask
        log     "pri ", r4
        poke    ISPR, 2
        settle
        cpsie   i
        isb
        cpsid   f
        mrs     r4, faultmask
        log     "flt ", r4
        poke    ISPR, 2
        settle
        pending
        cpsie   f
        isb
        mrs     r4, faultmask
        log     "flt ", r4

        @ A priority that is changed while it waits.
        note    "chng"
        order   18, ISPR, 1
        poke    ISPR, 4
        settle
        order   18, IPR, 0x60402010         @ irq0 is more urgent now
        cpsid   i
        poke    ISPR, 5
        poke    IPR, 0x60402080
        release
        pop     {r4, pc}
