/* Times a method on an ATmega328P at 8 MHz, sample by sample, and sends its angles by UART.
 *
 * Timer 1 counts every eighth cycle. A line is the count in decimals and the first angle as the
 * hexadecimal digits of a float. Sleep without interrupts ends simavr. */
#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/pgmspace.h>
#include <avr/sleep.h>
#include <stdint.h>
#include <string.h>

#include "signal.h" /* SAMPLES, COLUMNS, SIGNAL in flash */

void bench_start(void);
void bench_step(const float inputs[COLUMNS], float angles[3]);

static void send(char c)
{
    while (!(UCSR0A & (1 << UDRE0)))
        ;
    UDR0 = (uint8_t)c;
}

static void send_number(uint32_t number, uint8_t base, uint8_t digits)
{
    char text[10];
    uint8_t n = 0;
    do {
        const uint8_t digit = (uint8_t)(number % base);
        text[n++] = (char)(digit < 10 ? '0' + digit : 'a' + digit - 10);
        number /= base;
    } while (number > 0 || n < digits);
    while (n > 0)
        send(text[--n]);
}

int main(void)
{
    uint16_t k;
    UCSR0B = 1 << TXEN0;
    UBRR0 = 0;
    TCCR1B = 1 << CS11;
    bench_start();
    for (k = 0; k < SAMPLES; k++) {
        float inputs[COLUMNS], angles[3];
        uint16_t count;
        uint32_t bits;
        memcpy_P(inputs, SIGNAL[k], sizeof inputs);
        TCNT1 = 0;
        bench_step(inputs, angles);
        count = TCNT1;
        memcpy(&bits, angles, sizeof bits);
        send_number(count, 10, 1);
        send(' ');
        send_number(bits, 16, 8);
        send('\r');
        send('\n');
    }
    while (!(UCSR0A & (1 << TXC0)))
        ;
    cli();
    sleep_enable();
    sleep_cpu();
    return 0;
}
