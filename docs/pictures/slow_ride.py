"""A lift at 0.2 m/s: the barometer, the truth, the default's track and a zero-velocity rule's."""

import matplotlib.pyplot as plt

import baroarma as ba
from baroarma.simulation import BMP085, simulate

ride = simulate("lift", duration=90, speed=0.2, seed=1)
ours = ba.Tracker(noise=BMP085.noise).run(ride)
rule = ba.Tracker.preset("lee16-kf").run(ride)

figure, ax = plt.subplots()
altitude = ride.height() - ride.height()[:50].mean()
ax.plot(ride.t, altitude, ".", color="0.75", ms=1.5, label="barometer")
ax.plot(ride.t, ride.reference - ride.reference[0], color="black", lw=1.6, label="true height")
ax.plot(rule.t, rule.height, color="#D55E00", ls="--", label="zero velocity where nothing shakes (lee16-kf)")
ax.plot(ours.t, ours.height, color="#0072B2", label="rest weighed against motion (baroarma)")
ax.set(xlabel="time (s)", ylabel="height (m)")
ax.legend(fontsize="small")
