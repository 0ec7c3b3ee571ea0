// A stand-in for Arduino's library, to compile and run the sketch on a PC: a timer by hand, pins from stdin.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <vector>

enum { A0 = 14, A1, A2, A3, A4, A5, A6, A7, A8, A9, A10 = 24, A11, A12, A13, A14 = 38, A15, A16, A17 };

struct SerialPort {
    void begin(long) {}
    int availableForWrite() { return 4096; }
    void write(const char *text, size_t count) { std::fwrite(text, 1, count, stdout); }
    void print(const char *text) { std::fputs(text, stdout); }
    void print(uint32_t value) { std::printf("%lu", (unsigned long)value); }
    void print(int value) { std::printf("%d", value); }
    void print(double value, int digits) { std::printf("%.*f", digits, value); }
};

struct IntervalTimer {
    void (*call)() = nullptr;
    float us = 0;
    void begin(void (*function)(), float interval) {
        call = function;
        us = interval;
    }
};

static SerialPort Serial;
static std::vector<uint16_t> pins;
static const int BOARD[] = {A0, A1, A2, A3, A4, A5, A6, A7, A8, A9, A10, A12, A11, A13, A16, A14, A17, A15};
static int analogRead(int pin) {
    for (size_t c = 0;; c++)
        if (BOARD[c] == pin)
            return pins.at(c);
}
static void analogReadResolution(int) {}
static void analogReadAveraging(int) {}
