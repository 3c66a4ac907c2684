// SPDX-License-Identifier: GPL-2.0-or-later
// Seeded randomness of simulated machines. The same seed gives the same bits on every machine, so this code
// uses no function of the C library but the square root.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace plumb {

// A uniform generator (xoshiro256**, Blackman and Vigna 2018), its state filled by splitmix64. Generators of
// one seed and different streams are independent of each other.
class Random {
public:
    explicit Random(std::uint64_t seed = 0, std::uint64_t stream = 0) noexcept {
        std::uint64_t x = seed ^ scrambled(stream);
        for (std::uint64_t& word : state_) word = scrambled(x += 0x9e3779b97f4a7c15);
    }

    std::uint64_t bits() noexcept {
        const std::uint64_t result = rotated(state_[1] * 5, 7) * 9;
        const std::uint64_t shifted = state_[1] << 17;
        state_[2] ^= state_[0];
        state_[3] ^= state_[1];
        state_[1] ^= state_[2];
        state_[0] ^= state_[3];
        state_[2] ^= shifted;
        state_[3] = rotated(state_[3], 45);
        return result;
    }

    // In [0, 1).
    double uniform() noexcept { return static_cast<double>(bits() >> 11) * 0x1p-53; }
    double uniform(double low, double high) noexcept { return low + (high - low) * uniform(); }

    // One of 0 ... count - 1, for count >= 1.
    int index(int count) noexcept { return static_cast<int>(uniform() * count); }

    // Normal, mean 0, variance 1, never beyond 8.5: a sum of twelve uniforms, its tails stretched by
    // Teichroew's polynomial (Knuth, The Art of Computer Programming, vol. 2, 3.4.1).
    double gaussian() noexcept {
        std::uint64_t sum = 0;
        for (int draw = 0; draw < 3; ++draw) {
            const std::uint64_t x = bits();
            sum += (x & 0xffff) + (x >> 16 & 0xffff) + (x >> 32 & 0xffff) + (x >> 48);
        }
        const double r = (static_cast<double>(sum) - 6 * 65535.0) * (0.25 / 65536);
        const double q = r * r;
        return ((((0.029899776 * q + 0.008355968) * q + 0.076542912) * q + 0.252408784) * q + 3.949846138) *
               r;
    }

private:
    static std::uint64_t rotated(std::uint64_t x, int by) noexcept { return x << by | x >> (64 - by); }

    static std::uint64_t scrambled(std::uint64_t x) noexcept {
        x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9;
        x = (x ^ x >> 27) * 0x94d049bb133111eb;
        return x ^ x >> 31;
    }

    std::array<std::uint64_t, 4> state_;
};

// Noise whose spectral density falls as 1/f between 0.02 and 20 Hz, of rms 1: first-order processes of equal
// variance, their corners in a geometric row. Any spacing of the samples, which may vary; starts in its
// steady state.
class FlickerNoise {
public:
    explicit FlickerNoise(Random& random) noexcept {
        for (Process& each : processes_) each.value = random.gaussian();
    }

    // The value dt seconds after the last one, dt >= 0.
    double step(Random& random, double dt) noexcept {
        if (!(std::abs(dt - dt_) <= 1e-9)) keep(dt);
        double sum = 0;
        for (Process& each : processes_) {
            each.value = each.kept * each.value + each.added * random.gaussian();
            sum += each.value;
        }
        return sum * scale;
    }

private:
    // The parts of a step of dt, which are kept because their roots cost most.
    void keep(double dt) noexcept {
        dt_ = dt;
        double rate = slowest;
        for (Process& each : processes_) {
            each.kept = 1 / (1 + rate * dt);
            each.added = std::sqrt(1 - each.kept * each.kept);
            rate *= spacing;
        }
    }

    struct Process {
        double value, kept, added;  // its part of the last value, and of new noise
    };

    static constexpr double slowest = 0.0628;  // 1/s, a corner of 0.01 Hz
    static constexpr double spacing = 5;
    static constexpr double scale = 0.40824829046386302;  // 1/sqrt(6)

    std::array<Process, 6> processes_{};
    double dt_ = -1;
};

}  // namespace plumb
