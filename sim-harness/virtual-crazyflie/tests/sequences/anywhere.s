@ Work that an interrupt must leave alone, wherever it comes: IT blocks, exclusives, flags,
@ floating point, multiple transfers, tables.

        .equ    ACKNOWLEDGE, 0x40004000
        .equ    TAKEN, 0x20000010
        .equ    PLACE, 0x20000100

        @ Changes whatever a handler may change.
        function irq0
        ldr     r0, =ACKNOWLEDGE
        str     r0, [r0]
        ldr     r0, =TAKEN
        ldr     r1, [r0]
        adds    r1, r1, #1
        str     r1, [r0]
        ldr     r0, =PLACE + 64
        ldrex   r1, [r0]
        strex   r2, r1, [r0]
        set     r0, 0x7FC00000
        vmov    s0, r0
        vmov    s1, r0
        vmov    s7, r0
        vmov    s15, r0
        vadd.f32 s3, s0, s1
        vcmp.f32 s3, s0
        movs    r0, #0
        movs    r1, #0
        movs    r2, #0
        movs    r3, #0
        mov     r12, r0
        subs    r0, r0, #1
        dsb
        bx      lr

        .macro  mix reg
        eor     r11, r11, \reg
        ror     r11, r11, #5
        add     r11, r11, r11, lsl #3
        .endm

        function main
        push    {r4, r5, r6, r7, lr}
        poke    CPACR, 0x00F00000
        settle
        poke    ISER, 1
        set     r11, 0x12345678
        ldr     r4, =PLACE
        movs    r5, #0
        vmov    s0, r5
        set     r0, 0x3F800000
        vmov    s1, r0
        vmov.f32 s15, #0.5
        vmov.f32 s16, #0.25
        movs    r6, #2
1:      adds    r5, r5, #3
        lsls    r0, r5, #30
        itete   cs
        addcs   r5, r5, #1
        orrcc   r5, r5, #8
        eorcs   r5, r5, #16
        subcc   r5, r5, #2
        mix     r5
        cmp     r5, #9
        ittt    hi
        movhi   r1, #7
        cmphi   r1, #9
        addhi   r5, r5, #4
        mrs     r2, apsr
        mix     r2
2:      ldrex   r0, [r4]
        mov     r0, r11
        strex   r1, r0, [r4]
        cmp     r1, #0
        bne     2b
        ldr     r0, [r4]
        mix     r0
        vadd.f32 s0, s0, s1
        vfma.f32 s15, s0, s16
        vdiv.f32 s1, s15, s0
        vcmp.f32 s0, s1
        vmrs    apsr_nzcv, fpscr
        itt     gt
        vaddgt.f32 s16, s16, s1
        vmovgt  r0, s16
        mix     r0
        vmov    r1, r2, s0, s1
        stmia   r4, {r0, r1, r2, r5, r11}
        ldmia   r4!, {r1, r2, r3}
        ldrd    r0, r12, [r4], #-12
        mix     r1
        mix     r3
        mix     r12
        umull   r0, r1, r11, r5
        mix     r1
        qadd    r2, r11, r11
        mrs     r3, apsr
        mix     r3
        and     r0, r5, #3
        tbb     [pc, r0]
3:      .byte   (4f - 3b) / 2, (5f - 3b) / 2, (6f - 3b) / 2, (4f - 3b) / 2
4:      adds    r5, r5, #1
5:      mvns    r5, r5
6:      and     r5, r5, #0xFF
        vpush   {s15, s16}
        pop     {r0, r1}
        mix     r1
        svc     0
        subs    r6, r6, #1
        bne     1b
        vmov    r0, s15
        log     "s15 ", r0
        vmov    r0, s16
        log     "s16 ", r0
        vmrs    r0, fpscr
        log     "fpsc", r0
        log     "sum ", r11
        pop     {r4, r5, r6, r7, pc}

        function sv_call
        vmov    s0, r0
        eors    r0, r0
        bx      lr
        .ltorg
