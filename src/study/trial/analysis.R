# Reads the tables of this folder and asks which groups differ. Needs R alone; with the packages lme4 and ggplot2 it also fits
# mixed models and draws.
#   Rscript analysis.R            writes analysis.txt and, with ggplot2, analysis.pdf
traits <- read.csv("traits.csv", colClasses = c(plant = "character"), check.names = FALSE)
groups <- setdiff(names(traits), c("plant", "date", "trait", "value", "spread"))
traits[groups] <- lapply(traits[groups], factor)
sink("analysis.txt")
for (group in groups) {
  if (nlevels(traits[[group]]) < 2 || nlevels(traits[[group]]) >= length(unique(traits$plant))) next
  for (name in unique(traits$trait)) {
    all <- traits[traits$trait == name & is.finite(traits$value), ]
    if (nrow(all) < 4 || length(unique(all[[group]])) < 2 || sd(all$value) == 0) next
    last <- all[all$date == tail(sort(unique(all$date)), 1), ]
    cat("\n##", name, "by", group, "on", as.character(last$date[1]), "\n")
    if (all(table(last[[group]]) >= 2)) try(print(oneway.test(last$value ~ last[[group]])))  # Welch
    if (length(unique(all$date)) > 1 && requireNamespace("lme4", quietly = TRUE)) {
      model <- reformulate(c(paste0("factor(date) * `", group, "`"), "(1 | plant)"), "value")
      try(print(summary(lme4::lmer(model, data = all))))
    }
  }
}
sink()
if (requireNamespace("ggplot2", quietly = TRUE) && length(groups) > 0) {
  library(ggplot2)
  wanted <- c("total_root_length_mm", "root_count", "mean_diameter_mm", "depth_max_mm", "elongation_mm_per_day")
  shown <- traits[traits$trait %in% wanted, ]
  pdf("analysis.pdf", width = 10, height = 6)
  for (group in groups) {
    print(ggplot(shown, aes(factor(date), value, colour = .data[[group]])) +
      geom_boxplot(outlier.shape = NA) + geom_point(position = position_jitterdodge(jitter.width = 0.1)) +
      facet_wrap(~trait, scales = "free_y") + labs(x = "date", y = NULL))
  }
  dev.off()
}
