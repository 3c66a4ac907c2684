// SPDX-License-Identifier: GPL-2.0-or-later
// Spectra of noise, for tests.
#pragma once

#include <cmath>
#include <complex>
#include <vector>

namespace plumb {

// One line of a spectrum: frequency in Hz, and mean square per Hz.
struct SpectralLine {
    double frequency;
    double density;
};

// In place, for a power of two of values.
inline void fourier_transform(std::vector<std::complex<double>>& x) {
    const std::size_t n = x.size();
    if (n == 1) return;
    std::vector<std::complex<double>> even(n / 2), odd(n / 2);
    for (std::size_t i = 0; i < n / 2; ++i) {
        even[i] = x[2 * i];
        odd[i] = x[2 * i + 1];
    }
    fourier_transform(even);
    fourier_transform(odd);
    for (std::size_t i = 0; i < n / 2; ++i) {
        const auto turned =
            std::polar(1.0, -2 * M_PI * static_cast<double>(i) / static_cast<double>(n)) * odd[i];
        x[i] = even[i] + turned;
        x[i + n / 2] = even[i] - turned;
    }
}

// One-sided, by Welch's method: mean over Hann-windowed pieces of `piece` samples, a power of two, dt seconds
// apart.
inline std::vector<SpectralLine> spectral_density(const std::vector<double>& samples, double dt,
                                                  std::size_t piece) {
    std::vector<SpectralLine> result(piece / 2 - 1);
    for (std::size_t k = 0; k < result.size(); ++k)
        result[k] = {static_cast<double>(k + 1) / (static_cast<double>(piece) * dt), 0};
    const std::size_t pieces = samples.size() / piece;
    const double window_power = 0.375 * static_cast<double>(piece);
    for (std::size_t p = 0; p < pieces; ++p) {
        std::vector<std::complex<double>> x(piece);
        for (std::size_t i = 0; i < piece; ++i) {
            const double phase = 2 * M_PI * static_cast<double>(i) / static_cast<double>(piece);
            x[i] = samples[p * piece + i] * 0.5 * (1 - std::cos(phase));
        }
        fourier_transform(x);
        for (std::size_t k = 0; k < result.size(); ++k)
            result[k].density += 2 * std::norm(x[k + 1]) * dt / window_power / static_cast<double>(pieces);
    }
    return result;
}

// Exponent n of density ~ frequency^n between two frequencies: straight line through the mean levels of
// octaves.
inline double slope_of(const std::vector<SpectralLine>& lines, double from, double to) {
    double count = 0, sx = 0, sy = 0, sxx = 0, sxy = 0;
    for (double low = from; low * 2 <= to * 1.0001; low *= 2) {
        double level = 0, hits = 0;
        for (const SpectralLine& line : lines)
            if (line.frequency >= low && line.frequency < 2 * low) {
                level += line.density * line.frequency;  // flat within the octave for 1/f
                ++hits;
            }
        if (hits == 0) continue;
        const double x = std::log2(low), y = std::log2(level / hits) - std::log2(low * 1.5);
        ++count;
        sx += x;
        sy += y;
        sxx += x * x;
        sxy += x * y;
    }
    return (count * sxy - sx * sy) / (count * sxx - sx * sx);
}

}  // namespace plumb
