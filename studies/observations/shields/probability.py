"""The probability that a shield's wall is perforated, from the margins of the equations, calibrated on the shots.

The method, written down before its first fit:

1. The margin of an equation is x = ln(d/d_c), with its critical diameter d_c for the shot.
2. One curve an equation: logit P = a_r + b_r x + c theta, with an intercept and a slope for each range r of the normal
   speed (below 3, 3 to 7, from 7 km/s) and one coefficient of the obliquity theta in rad. It has the greatest posterior
   density with each shot of weight one, and priors that are normal about zero with standard deviations of 2.5 for a_r
   and c and of 10 for b_r: so weak that they matter where a range has few shots.
3. It is fitted to the published shots that the screening keeps and the equation's range covers.
4. P of a shield is the mean of the curves of those equations whose range covers it: none is best everywhere.
5. The interval holds what a laboratory that is not among these may find: of each curve expit(logit P -+ 1.96 s) with
   s^2 = f' C f + tau^2, where C is the covariance of the constants (the inverse curvature at the maximum), f the terms
   of the curve, and tau the standard deviation between laboratories: DerSimonian and Laird's (1986) estimate from an
   offset of the logit for each laboratory (one step of Newton from none). Of several equations it is the mean of the
   bounds.
6. It is validated by leaving out each laboratory in turn, all its reports at once: fitted to the others, asked about it.
   Each shot then has a prediction that has not seen its laboratory. Brier score over all shots, for the mean and each
   equation; reliability: shots in ten bins of equal number by P, of each the mean of P less the share of failures;
   intervals: in each laboratory left out its shots in the order of P are cut into groups of at least ten (fewer are one
   group with nothing cut), of each of which the number of failures is inside or outside the middle 95 % of its
   distribution, binomial about a logit that varies normally by the s of its shots.
"""
