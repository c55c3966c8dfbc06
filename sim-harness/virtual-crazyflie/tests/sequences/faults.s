@ Faults of instructions: which exception comes, what it is told, and what it becomes where it
@ cannot come.

        .equ    NOTHING, 0xA0000000         @ no memory, and execute-never
        .equ    NO_CODE, 0x90000000         @ no memory

        .macro  reporter name
        function \name
        b       report
        .endm

        reporter hard_fault
        reporter mem_manage
        reporter bus_fault
        reporter usage_fault

        @ Logs what there is to know, and returns to R11. R10 is where the attempt began.
        function report
        push    {r4, r5, r6, lr}
        log     "lr  ", lr
        peek    r5, CFSR
        tst     r5, #0x40000                @ INVPC: LR is what was wrong, and the frame is there
        itt     ne
        movne   lr, #0xFFFFFFF9
        strne   lr, [sp, #12]
        tst     lr, #4
        ite     eq
        addeq   r6, sp, #16
        mrsne   r6, psp
        mrs     r4, ipsr
        log     "exc ", r4
        log     "cfsr", r5
        peek    r4, HFSR
        log     "hfsr", r4
        peek    r4, SHCSR
        log     "shcs", r4
        tst     r5, #0x8000
        beq     1f
        peek    r4, BFAR
        log     "bfar", r4
1:      tst     r5, #0x1000                 @ STKERR: there is no frame, so one is made
        beq     2f
        set     r6, PROCESS_STACK - 0x20
        msr     psp, r6
        set     r4, 0x01000000
        str     r4, [r6, #28]
        b       3f
2:      ldr     r4, [r6, #24]
        subs    r4, r4, r10
        log     "pc  ", r4
        ldr     r4, [r6, #28]
        and     r4, r4, #0x01000000
        log     "thmb", r4
3:      str     r11, [r6, #24]
        ldr     r4, [r6, #28]
        bic     r4, r4, #0x06000000
        bic     r4, r4, #0xFC00
        orr     r4, r4, #0x01000000
        str     r4, [r6, #28]
        set     r4, 0xFFFFFFFF
        set     r5, CFSR
        str     r4, [r5]
        str     r4, [r5, #4]
        mrs     r4, control
        cmp     r9, #1                      @ the thread wants its privilege back
        bne     4f
        bic     r4, r4, #1
        msr     control, r4
4:      cmp     r8, #0                      @ a fault inside, once
        beq     5f
        mov     r8, #0
        push    {r6, r10, r11, lr}
        bl      inner
        pop     {r6, r10, r11, lr}
        note    "back"
5:      pop     {r4, r5, r6, pc}

        function sv_call
        push    {r4, r5, r6, lr}
        note    "svc "
        cmp     r8, #0
        beq     1f
        mov     r8, #0
        bl      inner
1:      cmp     r7, #0
        beq     2f
        add     sp, sp, #16
        mov     r0, r7
        mov     r7, #0
        bx      r0
2:      pop     {r4, r5, r6, pc}

        function irq0
        mrs     r4, ipsr
        log     "irq ", r4
        bx      lr

        @ An instruction that faults goes between these.
        .macro  begin tag
        note    "\tag"
        adr.w   r10, 7f
        adr.w   r11, 8f
        .p2align 2
7:
        .endm
        .macro  over
        .p2align 2
8:
        .endm

        function inner
        push    {r4, lr}
        begin   "inne"
        udf     #1
        over
        pop     {r4, pc}

        @ What a fault does first as a HardFault and then by itself.
        .macro  enable
        poke    SHCSR, 0x00070000
        .endm
        .macro  disable
        poke    SHCSR, 0
        .endm

        function main
        push    {r4, lr}
        mov     r7, #0
        mov     r8, #0
        mov     r9, #0

        @ Not enabled: all become HardFaults.
        begin   "udfh"
        udf     #0
        over
        set     r0, NOTHING
        begin   "bush"
        ldr     r1, [r0, #4]
        over
        set     r0, NOTHING + 1
        begin   "memh"
        bx      r0
        over

        enable
        begin   "udf "
        udf     #0
        over
        begin   "udfw"
        udf.w   #0
        over
        @ A branch to an even address: the fault is that of the next instruction.
        adr.w   r0, 7f
        begin   "even"
        bx      r0
        over
        begin   "pope"
        push    {r10}
        pop     {pc}
        over

        @ Coprocessors that are off, or not there.
        poke    CPACR, 0
        settle
        begin   "nocp"
        vmov    s0, r0
        over
        begin   "cp15"
        mrc     p15, 0, r0, c0, c0, 0
        over
        poke    CPACR, 0x00F00000
        settle

        @ Division by zero.
        movs    r1, #0
        movs    r2, #5
        udiv    r3, r2, r1
        log     "quot", r3
        poke    CCR, 0x210
        movs    r1, #0
        movs    r2, #5
        movs    r3, #6
        begin   "udiv"
        udiv    r3, r2, r1
        over
        begin   "sdiv"
        sdiv    r3, r2, r1
        over
        log     "kept", r3

        @ Alignment: what always has to be aligned.
        poke    CCR, 0x200
        set     r5, 0x20000101
        movs    r4, #0
        str     r4, [r5]
        ldr     r4, [r5]
        ldrh    r4, [r5]
        log     "fine", r4
        begin   "ldrd"
        ldrd    r0, r1, [r5]
        over
        begin   "strd"
        strd    r0, r1, [r5]
        over
        begin   "ldm "
        ldm     r5, {r0, r1}
        over
        begin   "stm "
        stm     r5, {r0, r1}
        over
        begin   "ldrx"
        ldrex   r0, [r5]
        over
        begin   "vldr"
        vldr    s0, [r5]
        over
        @ And with CCR.UNALIGN_TRP everything.
        poke    CCR, 0x208
        begin   "ldr "
        ldr     r0, [r5]
        over
        begin   "strh"
        strh    r0, [r5]
        over
        ldrb    r4, [r5]
        log     "byte", r4
        poke    CCR, 0x200

        @ The bus says no. No register changes, the base included.
        set     r5, NOTHING + 0x124
        set     r4, 0x11111111
        begin   "bldr"
        ldr     r4, [r5], #4
        over
        log     "r4  ", r4
        log     "r5  ", r5
        begin   "bldb"
        ldrb    r4, [r5, #3]
        over
        begin   "bstr"
        str     r4, [r5]
        over
        set     r0, NO_CODE + 1
        begin   "bins"
        bx      r0
        over
        set     r0, NOTHING + 1
        begin   "xn  "
        bx      r0
        over
        set     r0, 0x40000001
        begin   "xnio"
        bx      r0
        over

        @ In an IT block.
        movs    r4, #0
        begin   "itbl"
        cmp     r4, #0
        itt     eq
        addeq   r4, #1
        .inst.n 0xDE00
        over
        log     "r4  ", r4

        @ Where they cannot come in: in their own handler, at their own priority, under PRIMASK.
        mov     r8, #1
        begin   "ownh"
        udf     #0
        over
        poke    SHPR1, 0x00800000           @ UsageFault 80
        poke    SHPR2, 0x40000000           @ SVCall 40
        mov     r8, #1
        adr.w   r11, 1f
        svc     0
        .p2align 2
1:      poke    SHPR1, 0x00200000           @ UsageFault 20: now it can
        mov     r8, #1
        svc     0
        note    "thrd"
        poke    SHPR1, 0
        cpsid   i
        begin   "mask"
        udf     #0
        over
        begin   "msvc"
        svc     0
        over
        cpsie   i
        movs    r0, #0x20
        msr     basepri, r0
        begin   "bsvc"
        svc     0
        over
        movs    r0, #0
        msr     basepri, r0

        @ EXC_RETURNs that lead nowhere, and frames that do not fit.
        set     r7, 0xFFFFFFF5
        begin   "rsvd"
        svc     0
        over
        set     r7, 0xFFFFFFF1
        begin   "hand"
        svc     0
        over

        @ The thread without privilege.
        set     r0, PROCESS_STACK
        msr     psp, r0
        mov     r9, #1
        movs    r0, #3
        msr     control, r0
        isb
        set     r5, SHCSR
        begin   "user"
        ldr     r4, [r5]
        over
        movs    r0, #3
        msr     control, r0
        isb
        set     r5, STIR
        movs    r4, #0
        begin   "ustr"
        str     r4, [r5]
        over
        movs    r0, #3
        msr     control, r0
        isb
        begin   "usys"
        ldr     r4, [r5, #-240]
        over

        @ CCR.USERSETMPEND lets it have STIR.
        poke    CCR, 0x202
        poke    ISER, 1
        movs    r0, #3
        msr     control, r0
        isb
        movs    r4, #0
        set     r5, STIR
        str     r4, [r5]
        settle
        begin   "ucon"
        udf     #0
        over

        @ No room for a frame: BusFault comes first, then what was to come.
        set     r0, NOTHING + 0x40
        begin   "stak"
        msr     psp, r0
        svc     0
        over
        movs    r0, #0
        msr     control, r0
        isb
        b       finish
