// Light or dark: a button that tells how it stands, after a reload and in every tab.
export default {
  data() { return { dark: document.documentElement.dataset.theme === "dark" }; },
  mounted() { window.addEventListener("storage", this.follow); },
  beforeUnmount() { window.removeEventListener("storage", this.follow); },
  methods: {
    show(dark) { this.dark = dark; document.documentElement.dataset.theme = dark ? "dark" : "light"; },
    turn() {
      this.show(!this.dark);
      try { localStorage.setItem("valvetrain-theme", this.dark ? "dark" : "light"); } catch (error) { /* kept for this page only */ }
    },
    follow(event) { if (event.key === "valvetrain-theme" && event.newValue) { this.show(event.newValue === "dark"); } },
  },
  template: `<div><button type="button" class="button small" id="theme" :aria-pressed="dark ? 'true' : 'false'" @click="turn">Dark: {{ dark ? "on" : "off" }}</button></div>`,
};
