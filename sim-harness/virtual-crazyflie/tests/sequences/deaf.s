@ WFE under PRIMASK: what is pending is no event (DDI 0403, B1.5.18), so this sleeps for ever.

        function irq0
        note    "no  "
        bx      lr

        function main
        cpsid   i
        poke    ISER, 1
        sev
        wfe                                 @ takes what SEV left
        poke    ISPR, 1
        note    "wfe "
        wfe
        note    "no  "
        b       finish
