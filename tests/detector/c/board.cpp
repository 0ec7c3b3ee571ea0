// Runs the sketch: a row of counts a sample from stdin; the loop comes round after as many samples as arguments say.
#include "Arduino.h"
#include "skincad_detector.ino"
#include <cstdlib>

int main(int count, char **words) {
    const int every = count > 1 ? std::atoi(words[1]) : 1;
    pins.resize(SKINCAD_CHANNELS);
    setup();
    std::fprintf(stderr, "%g\n", timer.us);
    for (long i = 1; std::fread(pins.data(), 2, SKINCAD_CHANNELS, stdin) == SKINCAD_CHANNELS; i++) {
        timer.call();
        if (i % every == 0)
            loop();
    }
    for (int i = 0; i < 1000; i++)
        loop();
}
