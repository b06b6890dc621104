# Reads the tables of this folder and asks which groups differ. Needs R alone, with nlme, which comes with it, for mixed models.
#   Rscript analysis.R            writes analysis.txt and analysis.pdf
traits <- read.csv("traits.csv", colClasses = c(plant = "character", date = "character"), check.names = FALSE, na.strings = "")
# Without dates all captures are of one.
traits$date[is.na(traits$date)] <- ""
days <- unique(traits$date)
numbers <- suppressWarnings(as.numeric(days))
traits$date <- factor(traits$date, levels = if (anyNA(numbers)) sort(days) else days[order(numbers)])
groups <- setdiff(names(traits), c("plant", "date", "trait", "value", "spread"))
traits[groups] <- lapply(traits[groups], factor)
# A column that tells every plant apart compares nothing.
plants <- length(unique(traits$plant))
groups <- Filter(function(group) nlevels(traits[[group]]) > 1 && nlevels(traits[[group]]) < plants, groups)
compared <- list()

sink("analysis.txt")
cat(plants, "plants,", length(days), if (length(days) == 1) "date\n" else "dates\n")
for (group in groups) {
  for (name in unique(traits$trait)) {
    all <- droplevels(traits[traits$trait == name & is.finite(traits$value) & !is.na(traits[[group]]), ])
    all$group <- all[[group]]
    if (nrow(all) < 4 || nlevels(all$group) < 2 || sd(all$value) == 0) next
    last <- all[all$date == tail(levels(all$date), 1), ]
    cat("\n##", name, "by", group, if (nzchar(as.character(last$date[1]))) paste("on", last$date[1]), "\n")
    # A test needs plants, and some spread, in every group.
    enough <- tapply(last$value, last$group, function(x) length(x) > 1 && sd(x) > 0)
    if (nrow(last) > 3 && sum(!is.na(enough)) > 1 && all(enough, na.rm = TRUE)) {
      test <- oneway.test(value ~ group, data = last) # Welch
      print(test)
      compared[[length(compared) + 1]] <- data.frame(group = group, trait = name, date = last$date[1], p = test$p.value)
    } else {
      cat("too few plants for a test\n")
    }
    if (nlevels(all$date) > 1 && any(duplicated(all$plant)) && requireNamespace("nlme", quietly = TRUE)) {
      model <- try(nlme::lme(value ~ date * group, random = ~ 1 | plant, data = all), silent = TRUE)
      if (inherits(model, "try-error")) cat("no mixed model:", conditionMessage(attr(model, "condition")), "\n") else print(anova(model))
    }
  }
}
if (length(compared) > 0) {
  # Many tests find something by chance: p as it is, and by Holm over all of them.
  compared <- do.call(rbind, compared)
  compared$p_holm <- p.adjust(compared$p, "holm")
  cat("\n## All Welch tests\n")
  print(compared[order(compared$p), ], row.names = FALSE, digits = 3)
}
sink()

wanted <- c("total_root_length_mm", "root_count", "mean_diameter_mm", "depth_max_mm", "elongation_mm_per_day")
pdf("analysis.pdf", width = 10, height = 6)
for (group in groups) {
  par(mfrow = c(2, 3), mar = c(6, 4, 2, 1))
  for (name in intersect(wanted, traits$trait)) {
    all <- droplevels(traits[traits$trait == name & is.finite(traits$value) & !is.na(traits[[group]]), ])
    if (nrow(all) == 0) next
    all$cell <- interaction(all[[group]], all$date, sep = " ", drop = TRUE)
    colours <- hcl.colors(nlevels(all[[group]]), "Dark 3")
    of <- tapply(as.integer(all[[group]]), all$cell, function(x) x[1])
    boxplot(value ~ cell, data = all, outline = FALSE, border = colours[of], las = 2, xlab = "", ylab = "", main = name)
    stripchart(value ~ cell, data = all, vertical = TRUE, method = "jitter", pch = 19, cex = 0.7, col = colours[of], add = TRUE)
  }
}
invisible(dev.off())
