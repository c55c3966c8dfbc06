//! Names of tasks and interrupts.

/// Interrupts of an STM32F405 (RM0090, "Vector table"), from number 0 on.
const INTERRUPTS: [&str; 82] = [
    "WWDG",
    "PVD",
    "TAMP_STAMP",
    "RTC_WKUP",
    "FLASH",
    "RCC",
    "EXTI0",
    "EXTI1",
    "EXTI2",
    "EXTI3",
    "EXTI4",
    "DMA1_STREAM0",
    "DMA1_STREAM1",
    "DMA1_STREAM2",
    "DMA1_STREAM3",
    "DMA1_STREAM4",
    "DMA1_STREAM5",
    "DMA1_STREAM6",
    "ADC",
    "CAN1_TX",
    "CAN1_RX0",
    "CAN1_RX1",
    "CAN1_SCE",
    "EXTI9_5",
    "TIM1_BRK_TIM9",
    "TIM1_UP_TIM10",
    "TIM1_TRG_COM_TIM11",
    "TIM1_CC",
    "TIM2",
    "TIM3",
    "TIM4",
    "I2C1_EV",
    "I2C1_ER",
    "I2C2_EV",
    "I2C2_ER",
    "SPI1",
    "SPI2",
    "USART1",
    "USART2",
    "USART3",
    "EXTI15_10",
    "RTC_ALARM",
    "OTG_FS_WKUP",
    "TIM8_BRK_TIM12",
    "TIM8_UP_TIM13",
    "TIM8_TRG_COM_TIM14",
    "TIM8_CC",
    "DMA1_STREAM7",
    "FSMC",
    "SDIO",
    "TIM5",
    "SPI3",
    "UART4",
    "UART5",
    "TIM6_DAC",
    "TIM7",
    "DMA2_STREAM0",
    "DMA2_STREAM1",
    "DMA2_STREAM2",
    "DMA2_STREAM3",
    "DMA2_STREAM4",
    "ETH",
    "ETH_WKUP",
    "CAN2_TX",
    "CAN2_RX0",
    "CAN2_RX1",
    "CAN2_SCE",
    "OTG_FS",
    "DMA2_STREAM5",
    "DMA2_STREAM6",
    "DMA2_STREAM7",
    "USART6",
    "I2C3_EV",
    "I2C3_ER",
    "OTG_HS_EP1_OUT",
    "OTG_HS_EP1_IN",
    "OTG_HS_WKUP",
    "OTG_HS",
    "DCMI",
    "CRYP",
    "RNG",
    "FPU",
];

/// An exception by its number in IPSR.
pub(super) fn exception(number: u16) -> String {
    let name = match number {
        2 => "NMI",
        3 => "HardFault",
        4 => "MemManage",
        5 => "BusFault",
        6 => "UsageFault",
        11 => "SVCall",
        12 => "DebugMonitor",
        14 => "PendSV",
        15 => "SysTick",
        _ => {
            let interrupt = usize::from(number).checked_sub(16);
            match interrupt.and_then(|interrupt| INTERRUPTS.get(interrupt)) {
                Some(name) => name,
                None => return format!("exception {number}"),
            }
        }
    };
    name.to_owned()
}

/// The future that a task runs, of the name of `TaskStorage<future>::poll`.
pub(super) fn future_of(poll: &str) -> Option<&str> {
    poll.strip_prefix("<embassy_executor::raw::TaskStorage<")?.strip_suffix(">>::poll")
}

/// A task by the name of its future: the modules it lies in, and its function unless that is called
/// `run`. Of `firmware::imu::__gyro_task::__gyro_task_inner_function::{closure#0}`, "imu gyro".
pub(super) fn task(future: &str) -> String {
    let mut words: Vec<&str> = future.split("::").collect();
    // As embassy's macro writes it.
    let inner = words.iter().position(|word| {
        word.strip_prefix("__").is_some_and(|word| word.ends_with("_task_inner_function"))
    });
    let Some(inner) = inner else { return future.to_owned() };
    let function = words[inner].trim_start_matches("__").trim_end_matches("_task_inner_function");
    words.truncate(inner.saturating_sub(1));
    let modules = words.get(1..).unwrap_or_default();
    let mut name: Vec<&str> = modules.to_vec();
    if function != "run" || modules.is_empty() {
        name.push(function);
    }
    name.join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_task_is_called_by_its_module_and_function() {
        let poll = |inside: &str| format!("<embassy_executor::raw::TaskStorage<{inside}>>::poll");
        for (inside, is) in [
            ("fw::imu::__gyro_task::__gyro_task_inner_function::{closure#0}", "imu gyro"),
            ("fw::control::__run_task::__run_task_inner_function::{closure#0}", "control"),
            ("fw::__blink_task::__blink_task_inner_function::{closure#0}", "blink"),
            ("fw::__run_task::__run_task_inner_function::{closure#0}", "run"),
            ("fw::by_hand::{closure#0}", "fw::by_hand::{closure#0}"),
        ] {
            assert_eq!(future_of(&poll(inside)).map(task).as_deref(), Some(is));
        }
        assert_eq!(future_of("<core::future::PollFn<x> as Future>::poll"), None);
    }

    #[test]
    fn interrupts_have_the_numbers_of_the_manual() {
        for (number, is) in [
            (15, "SysTick"),
            (16, "WWDG"),
            (16 + 18, "ADC"),
            (16 + 31, "I2C1_EV"),
            (16 + 50, "TIM5"),
            (16 + 66, "CAN2_SCE"),
            (16 + 71, "USART6"),
            (16 + 81, "FPU"),
            (16 + 82, "exception 98"),
            (7, "exception 7"),
        ] {
            assert_eq!(exception(number), is);
        }
    }
}
