@ A fault in the handler of HardFault: the core locks up.

        function hard_fault
        note    "hard"
        udf     #0
        note    "no  "
        b       finish

        function main
        note    "main"
        udf     #0
        note    "no  "
        bx      lr
