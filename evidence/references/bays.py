"""Volumes and joint areas of vaults over a bay from their section, by hand: moments of polygons and prismoids."""

import numpy as np
from shapely import Polygon


class Bay:
    """Two barrels of n straight-sided courses over half spans `reach`, round along x.

    Sections are drawn with the half span as unit of width.
    """

    def __init__(self, spans, thickness, n):
        self.reach = np.array(spans) / 2
        radius, self.n, self.courses = spans[0] / 2, n, n // 2
        angle = np.pi * np.arange(n // 2 + 1) / n
        self.p = np.cos(angle)[:, None] * (1, 1 + thickness / radius)
        self.z = np.sin(angle)[:, None] * (radius, radius + thickness)
        if n % 2 == 0:
            self.p[-1] = 0

    def section(self, course):
        i = course
        return Polygon([(self.p[j, k], self.z[j, k]) for j, k in ((i, 0), (i, 1), (i + 1, 1), (i + 1, 0))])

    def bed_width(self, i, across):
        """Width of joint i in the barrel across an axis [m]."""
        return np.hypot(self.reach[across] * np.ptp(self.p[i]), np.ptp(self.z[i]))

    def _prismoid(self, area):
        """Volume over the height of the crown course where the area of a level is at most quadratic."""
        return np.ptp(self.z[-1]) / 6 * (area(self.p[-1, 0]) + 4 * area(self.p[-1].mean()) + area(self.p[-1, 1]))

    def key_volume(self):
        return self._prismoid(lambda p: 4 * self.reach.prod() * p**2)

    def crown_area(self, across):
        """Section of the crown course."""
        return self._prismoid(lambda p: 2 * self.reach[across] * p)

    def groin_volume(self):
        edge, total = self.p[0, 1], 0.0
        for course in range(self.courses):
            s = self.section(course)
            total += 8 * self.reach.prod() * s.area * (edge - s.centroid.x)
        if self.n % 2:
            total += self.key_volume() + self._prismoid(lambda p: 8 * self.reach.prod() * p * (edge - p))
        return total

    def groin_beds(self):
        edge, total = self.p[0, 1], 0.0
        for i in range(self.courses + 1):
            arms = 2 if i == self.courses and self.n % 2 == 0 else 4  # a joint at the crown has courses on both sides
            for across in (0, 1):
                length = self.reach[1 - across] * (edge - self.p[i].mean())
                total += arms * self.bed_width(i, across) * length
        return total + (self.key_sides() if self.n % 2 else 0.0)

    def pavilion_volume(self):
        total = self.key_volume() if self.n % 2 else 0.0
        for course in range(self.courses):
            s = self.section(course)
            total += 8 * self.reach.prod() * s.area * s.centroid.x
        return total

    def pavilion_beds(self):
        last = self.courses if self.n % 2 else self.courses - 1  # an even number comes to a point
        return sum(
            4 * self.bed_width(i, across) * self.reach[1 - across] * self.p[i].mean()
            for i in range(last + 1)
            for across in (0, 1)
        )

    def key_sides(self):
        """Four sides of the keystone."""
        return sum(
            4 * self.reach[across] * self.p[-1].mean() * self.bed_width(self.courses, 1 - across) for across in (0, 1)
        )

    def mitres(self):
        """Joints in the diagonal planes."""
        return 4 * np.hypot(*self.reach) * sum(self.section(c).area for c in range(self.courses))
