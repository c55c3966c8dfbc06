@ Floating-point state over exceptions: extended frames, lazy saving, FPDSCR, no coprocessor.

        .macro  float reg, value
        set     r0, \value
        vmov    \reg, r0
        .endm

        .macro  control_is
        mrs     r4, control
        log     "ctrl", r4
        .endm

        @ FPCCR without what is unknown of THREAD and USER while nothing is outstanding.
        .macro  outstanding
        peek    r4, FPCCR
        and     r4, r4, #1
        log     "lspa", r4
        .endm

        .macro  single tag, reg
        vmov    r4, \reg
        log     "\tag", r4
        .endm

        @ R7 chooses what the handler does.
        function sv_call
        push    {r4, r5, r6, lr}
        add     r6, sp, #16                 @ the frame
        log     "lr  ", lr
        mov     r4, r6
        log     "sp  ", r4
        control_is
        outstanding
        peek    r4, FPCAR
        subs    r4, r4, r6
        cmp     r7, #1
        bhi     1f
        log     "car ", r4
1:      tbb     [pc, r7]
2:      .byte   (3f - 2b) / 2, (4f - 2b) / 2, (5f - 2b) / 2, (6f - 2b) / 2, (7f - 2b) / 2, (8f - 2b) / 2
        @ 0: nothing. The room for S0 was not touched.
3:      ldr     r4, [r6, #0x20]
        log     "room", r4
        b       9f
        @ 1: uses the unit. That saves what was left of the thread, first.
4:      vmrs    r4, fpscr
        log     "fpsc", r4
        outstanding
        control_is
        ldr     r4, [r6, #0x20]
        log     "s0  ", r4
        ldr     r4, [r6, #0x5C]
        log     "s15 ", r4
        ldr     r4, [r6, #0x60]
        log     "sfps", r4
        float   s0, 0x41100000
        float   s15, 0x41200000
        vadd.f32 s1, s0, s15
        vdiv.f32 s2, s0, s15
        b       9f
        @ 2: a basic frame, and the unit used in it.
5:      float   s20, 0x42000000
        control_is
        b       9f
        @ 3: asks for irq0, more urgent, which uses the unit.
6:      poke    ISPR, 1
        settle
        outstanding
        b       9f
        @ 4: the same after using it.
7:      float   s1, 0x42280000
        poke    ISPR, 1
        settle
        single  "own ", s1
        b       9f
        @ 5: looks at the frame that was saved at once.
8:      ldr     r4, [r6, #0x20]
        log     "s0  ", r4
        ldr     r4, [r6, #0x60]
        log     "sfps", r4
9:      pop     {r4, r5, r6, pc}

        function irq0
        push    {r4, lr}
        log     "irq ", lr
        outstanding
        float   s0, 0x43000000
        float   s1, 0x43000000
        outstanding
        pop     {r4, pc}

        function usage_fault
        peek    r4, CFSR
        log     "cfsr", r4
        ldr     r4, [sp, #24]
        ldrh    r4, [r4]
        log     "code", r4
        log     "lr  ", lr
        poke    CFSR, 0xFFFFFFFF
        poke    CPACR, 0x00F00000
        settle
        bx      lr

        .macro  try what
        note    "try ", \what
        movs    r7, #\what
        svc     0
        settle
        .endm

        .macro  thread_state
        control_is
        single  "s0' ", s0
        single  "s1' ", s1
        single  "s15'", s15
        single  "s16'", s16
        vmrs    r4, fpscr
        log     "fps'", r4
        .endm

        .macro  load_state
        float   s0, 0x3F800000
        float   s1, 0x40000000
        float   s15, 0x40400000
        float   s16, 0x40800000
        set     r0, 0x80C00001
        vmsr    fpscr, r0
        .endm

        function main
        push    {r4, lr}
        poke    SHCSR, 0x00040000
        poke    ISER, 1
        poke    IPR, 0x00000000
        poke    SHPR2, 0x80000000           @ SVCall below irq0
        peek    r4, FPCCR
        and     r4, r4, #0xC0000000
        log     "fpcc", r4
        control_is

        @ Disabled, the unit faults; the handler enables it, and the instruction goes ahead.
        vmov    r4, s0
        control_is

        @ A new context takes its modes from FPDSCR, and keeps the flags.
        mrs     r0, control
        bic     r0, r0, #4
        msr     control, r0
        isb
        try     2
        control_is
        poke    FPDSCR, 0x03400000
        vmrs    r4, fpscr
        log     "newc", r4
        poke    FPDSCR, 0
        load_state
        thread_state

        @ Room is left, and only that.
        set     r0, 0x5EED5EED
        sub     r1, sp, #0x48
        str     r0, [r1]
        try     0
        thread_state
        try     1
        thread_state
        sub     sp, sp, #4
        try     1
        add     sp, sp, #4
        thread_state
        try     3
        thread_state
        try     4
        thread_state

        @ Saved at once.
        poke    FPCCR, 0x80000000
        load_state
        try     5
        thread_state
        try     4
        thread_state

        @ Never saved: what a handler does to the registers stays done.
        mrs     r0, control
        bic     r0, r0, #4
        msr     control, r0
        poke    FPCCR, 0
        isb
        load_state
        control_is
        try     2
        try     3
        thread_state
        pop     {r4, pc}
